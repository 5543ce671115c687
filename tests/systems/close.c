/* usage: close.exe PROGRAM ARGUMENT...
   Runs a program until the file `close` appears, and then ends it as Windows does when a console window is closed: a new
   thread in the program calls its console handlers with CTRL_CLOSE_EVENT; 5 s later it is terminated.
   `closed` receives the program's exit code. */
#include <stdio.h>
#include <string.h>
#include <windows.h>

int main(void)
{
    STARTUPINFOA start = {sizeof start};
    PROCESS_INFORMATION child;
    char *command = strchr(GetCommandLineA(), ' ');
    while (command && *command == ' ')
        command++;
    if (!command || !CreateProcessA(NULL, command, NULL, NULL, FALSE, 0, NULL, NULL, &start, &child))
        return 2;
    while (GetFileAttributesA("close") == INVALID_FILE_ATTRIBUTES)
        Sleep(20);
    void *handlers = (void *)GetProcAddress(GetModuleHandleA("kernelbase"), "CtrlRoutine");
    if (!handlers || !CreateRemoteThread(child.hProcess, NULL, 0, (LPTHREAD_START_ROUTINE)handlers, (void *)CTRL_CLOSE_EVENT, 0, NULL))
        return 3;
    DWORD code = 1;
    if (WaitForSingleObject(child.hProcess, 5000) == WAIT_OBJECT_0)
        GetExitCodeProcess(child.hProcess, &code);
    else
        TerminateProcess(child.hProcess, code);
    FILE *closed = fopen("closed", "w");
    fprintf(closed, "%lu", code);
    return fclose(closed);
}
