/* Runs a replay program on an emulated ATmega2560.

   usage: replay PROGRAM.elf < CALLS > RESULTS

   CALLS is a sequence of frames: a length (1 byte), then the bytes of one call. The program reads them from GPIOR0 and
   writes its results to GPIOR1. RESULTS has a frame for each call: the cycles from its first byte read to that of the next call
   (4 bytes, little endian), a length (1 byte), then the bytes. A last frame with 0xFFFFFFFF cycles holds the bytes of stack used
   and spare (2 bytes each).

   Copyright (C) 2026 the authors of Groundwave. Because simavr is, this program is free software under the GNU General
   Public License, version 3 or later. It is a test tool in a process of its own and no part of the ground station. */
#include <sim_avr.h>
#include <sim_elf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { GPIOR0 = 0x3E, GPIOR1 = 0x4A, GPIOR2 = 0x4B, RAM = 0x200, PAINT = 0xC5 };

static struct {
    uint8_t call[255], length, next;
    uint8_t result[255], results;
    avr_cycle_count_t began;
    int has_begun;
    uint32_t stack_bottom;
} run;

/* simavr prints messages to standard output. */
static FILE *results;

static void write_word(uint32_t word, int bytes) {
    for (; bytes; bytes--, word >>= 8) putc(word & 0xFF, results);
}

static void finish(avr_t *avr) {
    uint32_t lowest = run.stack_bottom;
    while (lowest <= avr->ramend && avr->data[lowest] == PAINT) lowest++;
    write_word(0xFFFFFFFF, 4);
    putc(4, results);
    write_word(avr->ramend + 1 - lowest, 2);
    write_word(lowest - run.stack_bottom, 2);
    exit(fflush(results) ? 1 : 0);
}

static uint8_t read_call(avr_t *avr, avr_io_addr_t address, void *unused) {
    (void)address, (void)unused;
    if (run.next == run.length) {
        if (run.has_begun) {
            write_word((uint32_t)(avr->cycle - run.began), 4);
            putc(run.results, results);
            fwrite(run.result, 1, run.results, results);
        }
        int length = getchar();
        if (length == EOF) finish(avr);
        if (length == 0 || fread(run.call, 1, length, stdin) != (size_t)length) {
            fprintf(stderr, "replay: the calls end within a frame\n");
            exit(1);
        }
        run.length = length;
        run.next = run.results = 0;
        run.began = avr->cycle;
        run.has_begun = 1;
    }
    return run.call[run.next++];
}

static void write_result(avr_t *avr, avr_io_addr_t address, uint8_t value, void *unused) {
    (void)avr, (void)address, (void)unused;
    if (run.results == sizeof run.result) {
        fprintf(stderr, "replay: a result of more than 255 bytes\n");
        exit(1);
    }
    run.result[run.results++] = value;
}

static void report_panic(avr_t *avr, avr_io_addr_t address, uint8_t value, void *unused) {
    (void)address, (void)value, (void)unused;
    fflush(results);
    fprintf(stderr, "replay: the program panicked near 0x%x\n", avr->pc);
    exit(1);
}

int main(int count, char **arguments) {
    results = fdopen(dup(STDOUT_FILENO), "w");
    if (!results || !freopen("/dev/null", "w", stdout)) {
        perror("replay");
        return 1;
    }
    elf_firmware_t firmware;
    memset(&firmware, 0, sizeof firmware);
    if (count != 2 || elf_read_firmware(arguments[1], &firmware)) {
        fprintf(stderr, "usage: replay PROGRAM.elf < CALLS > RESULTS\n");
        return 2;
    }
    avr_t *avr = avr_make_mcu_by_name("atmega2560");
    if (!avr) {
        fprintf(stderr, "replay: simavr has no ATmega2560\n");
        return 1;
    }
    avr_init(avr);
    avr->log = LOG_ERROR;
    avr->frequency = 16000000;
    avr_load_firmware(avr, &firmware);
    run.stack_bottom = RAM + firmware.datasize + firmware.bsssize;
    memset(avr->data + run.stack_bottom, PAINT, avr->ramend + 1 - run.stack_bottom);
    avr_register_io_read(avr, GPIOR0, read_call, NULL);
    avr_register_io_write(avr, GPIOR1, write_result, NULL);
    avr_register_io_write(avr, GPIOR2, report_panic, NULL);
    for (;;) {
        int state = avr_run(avr);
        if (state == cpu_Done || state == cpu_Crashed) {
            fprintf(stderr, "replay: the program stopped at 0x%x\n", avr->pc);
            return 1;
        }
    }
}
