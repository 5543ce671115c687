/* Runs the program of the Mega's board with a world on its pins, one millisecond a step.

   usage: board PROGRAM.elf < COMMANDS > ANSWERS

   Commands and their answers; words are little endian:
     S  step: edges of both encoders (1 byte each), levels of C, L and K, millivolts of A0, A1, A2 (2 bytes each), number of
        bytes from the radio (1 byte), the bytes. Answer: pulse widths (2 bytes), port A, flags (1 and 2 left and right sonar
        triggered), the LEDs' carrier and the tone in Hz, the servo's pulse in us if there are 50 a second, awake cycles
        (2 bytes each), number of bytes to the radio (2 bytes), the bytes, number of traced bytes before a reset of the chip, or 65,535 (2 bytes), number of traced bytes (2 bytes), the
        bytes.
     E  echo: side (0 or 1), pulse in us (4 bytes). The pulse begins 0.45 ms after the command.
     P  power lost and restored: RAM has other contents, and a byte of EEPROM that was being written is damaged.
     W  a reset in the middle of a write of the EEPROM, the next one counted as 1 (2 bytes), or of none (0); its reason (1
        byte): 1 as P, 4 as B.
     B  brown-out: a reset in which RAM keeps its contents.
     H  the program hangs at its present place, with interrupts on or off (1 byte).
     X  the program calls the function at an address (4 bytes).
     L  display. Answer: its two lines (16 characters each).
     F  figures. Answer: bytes of stack used and spare, received bytes lost, bits per second (2 bytes each).

   Copyright (C) 2026 the authors of Groundwave. Because simavr is, this program is free software under the GNU General
   Public License, version 3 or later. It is a test tool in a process of its own and no part of the ground station. */
#include <avr_adc.h>
#include <avr_eeprom.h>
#include <avr_extint.h>
#include <avr_ioport.h>
#include <avr_uart.h>
#include <sim_avr.h>
#include <sim_elf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    STEP_CYCLES = 16000,
    PORTA = 0x22, TIFR4 = 0x39, EECR = 0x3F, EEARL = 0x41, TCCR0A = 0x44, TCCR0B = 0x45, OCR0A = 0x47, GPIOR1 = 0x4A, MCUSR = 0x54,
    OCR1A = 0x88, OCR1B = 0x8A, ICR3 = 0x96, OCR3A = 0x98, TCCR2A = 0xB0, TCCR2B = 0xB1, OCR2A = 0xB3,
    PORTH = 0x102, DISPLAY_WAKES = 6,
    READS = 1, WRITES = 2, ENABLES_WRITE = 4, WRITE_US = 3400, SERVO_COUNTS = 40000,
    RAM = 0x200, PAINT = 0xC5,
    BEFORE_ECHO_US = 450, WATCHDOG_US = 125000, RECEIVER_BYTES = 2, QUEUE = 4096, TRACE = 65534, NO_RESET = 65535
};

DEFINE_FIFO(uint16_t, uart_fifo);

static avr_t *avr;
static avr_uart_t *uart;
static avr_cycle_count_t byte_cycles;
static FILE *answers;
static uint32_t stack_bottom;
static uint16_t lost_bytes;

/* What the program has done since the last step. */
static struct {
    uint8_t flags;
    avr_cycle_count_t asleep;
    uint8_t sent[QUEUE], traced[TRACE];
    uint16_t sends, traces, traces_before_reset;
} done = {.traces_before_reset = NO_RESET};

static struct {
    uint8_t bytes[QUEUE];
    uint16_t first, count;
    avr_cycle_count_t due;
} uplink;

static struct {
    int edges[2], level[2];
    avr_cycle_count_t apart[2];
} wheels;

static uint32_t echo_us[2];

static struct {
    uint16_t address;
    avr_cycle_count_t end;
    int enabled;
    /* Writes up to the one with a reset, and the reason. */
    uint16_t to_loss;
    uint8_t reason;
    int is_lost;
} writing;

static struct {
    avr_flashaddr_t address;
    uint8_t code[2];
    int on;
} hang;

/* An HD44780 with four data wires: half bytes until it has woken, then bytes. */
static struct {
    uint8_t text[2][16], column, line, high, enabled;
    unsigned halves;
} display;

static uint32_t chance = 1;

static uint8_t random_byte(void) {
    chance = chance * 1664525 + 1013904223;
    return chance >> 24;
}

static void fail(const char *text) {
    fflush(answers);
    fprintf(stderr, "board: %s at 0x%x\n", text, avr ? avr->pc : 0);
    exit(1);
}

static uint8_t read_byte(void) {
    int byte = getchar();
    if (byte == EOF) fail("the commands end within one");
    return byte;
}

static uint32_t read_word(int bytes) {
    uint32_t word = 0;
    for (int i = 0; i < bytes; i++) word |= (uint32_t)read_byte() << 8 * i;
    return word;
}

static void write_word(uint32_t word, int bytes) {
    for (; bytes; bytes--, word >>= 8) putc(word & 0xFF, answers);
}

static uint16_t pair(int address) {
    return avr->data[address] | avr->data[address + 1] << 8;
}

static void set_pin(char port, int bit, int level) {
    avr_irq_t *pin = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ(port), bit);
    /* A reset clears the register of a pin, and the model would not raise an equal level again. */
    pin->flags |= IRQ_FLAG_INIT;
    avr_raise_irq(pin, level);
}

/* Timers. */

static avr_cycle_count_t end_step(avr_t *chip, avr_cycle_count_t when, void *unused) {
    (void)chip, (void)when, (void)unused;
    return 0;
}

static avr_cycle_count_t turn_wheel(avr_t *chip, avr_cycle_count_t when, void *side_of) {
    (void)chip;
    int side = (int)(intptr_t)side_of;
    wheels.level[side] ^= 1;
    set_pin('E', 4 + side, wheels.level[side]);
    return --wheels.edges[side] > 0 ? when + wheels.apart[side] : 0;
}

static avr_cycle_count_t end_echo(avr_t *chip, avr_cycle_count_t when, void *side_of) {
    (void)chip, (void)when;
    set_pin('L', (int)(intptr_t)side_of, 0);
    return 0;
}

static avr_cycle_count_t begin_echo(avr_t *chip, avr_cycle_count_t when, void *side_of) {
    (void)when;
    set_pin('L', (int)(intptr_t)side_of, 1);
    avr_cycle_timer_register_usec(chip, echo_us[(int)(intptr_t)side_of], end_echo, side_of);
    return 0;
}

/* The model holds 64 received bytes, the chip two. */
static avr_cycle_count_t deliver(avr_t *chip, avr_cycle_count_t when, void *unused) {
    (void)chip, (void)unused;
    if (uart_fifo_get_read_size(&uart->input) >= RECEIVER_BYTES)
        lost_bytes++;
    else
        avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('1'), UART_IRQ_INPUT), uplink.bytes[uplink.first]);
    uplink.first = (uplink.first + 1) % QUEUE;
    uplink.due = when + byte_cycles;
    return --uplink.count ? uplink.due : 0;
}

/* Hooks of the program. */

static void note_sent(struct avr_irq_t *irq, uint32_t value, void *unused) {
    (void)irq, (void)unused;
    if (done.sends < QUEUE) done.sent[done.sends++] = value;
}

static void note_trigger(struct avr_irq_t *irq, uint32_t value, void *flag) {
    (void)irq;
    if (value) done.flags |= (intptr_t)flag;
}

static void note_display(struct avr_irq_t *irq, uint32_t enabled, void *unused) {
    (void)irq, (void)unused;
    int falls = display.enabled && !enabled;
    display.enabled = enabled;
    if (!falls) return;
    uint8_t port = avr->data[PORTH], half = port >> 3 & 0xF;
    if (display.halves++ < DISPLAY_WAKES) return;
    if ((display.halves - DISPLAY_WAKES) % 2) {
        display.high = half;
        return;
    }
    uint8_t byte = display.high << 4 | half;
    if (port & 1) {
        if (display.column < 16) display.text[display.line][display.column++] = byte;
    } else if (byte & 0x80) {
        display.line = byte >> 6 & 1;
        display.column = byte & 0x3F;
    }
}

static void note_trace(avr_t *chip, avr_io_addr_t address, uint8_t value, void *unused) {
    (void)chip, (void)address, (void)unused;
    if (done.traces == TRACE) fail("too many traced bytes");
    done.traced[done.traces++] = value;
}

static void note_sleep(avr_t *chip, avr_cycle_count_t cycles) {
    (void)chip;
    done.asleep += cycles;
}

/* The model ends a write of the EEPROM at once, the chip after 3.4 ms. */
static uint8_t read_eecr(avr_t *chip, avr_io_addr_t address, void *unused) {
    (void)unused;
    return (chip->data[address] & ~WRITES) | (chip->cycle < writing.end ? WRITES : 0);
}

static avr_cycle_count_t end_power(avr_t *chip, avr_cycle_count_t when, void *unused) {
    (void)chip, (void)when, (void)unused;
    writing.is_lost = 1;
    return 0;
}

static void write_eecr(avr_t *chip, avr_io_addr_t address, uint8_t value, void *unused) {
    (void)address, (void)unused;
    int is_busy = chip->cycle < writing.end;
    if (is_busy && value & READS) fail("the EEPROM is read during a write");
    if (writing.enabled && value & WRITES) {
        if (is_busy) fail("a write of the EEPROM within another");
        writing.address = pair(EEARL);
        writing.end = chip->cycle + (uint64_t)WRITE_US * chip->frequency / 1000000;
        if (writing.to_loss && !--writing.to_loss)
            avr_cycle_timer_register_usec(chip, WRITE_US / 8, end_power, NULL);
    }
    writing.enabled = (value & ENABLES_WRITE) != 0;
}

/* The model drops every pending interrupt of a timer when the program clears one of its flags, the chip only that one. */
static struct pending {
    uint8_t number, flag;
    avr_int_vector_t *vector;
    avr_cycle_count_t dropped;
} clock_a = {.number = 42, .flag = 1 << 1}, capture_4 = {.number = 41, .flag = 1 << 5};

static void note_pending(struct avr_irq_t *irq, uint32_t is_pending, void *pending) {
    (void)irq;
    if (!is_pending) ((struct pending *)pending)->dropped = avr->cycle;
}

static void keep_pending(avr_t *chip, avr_io_addr_t address, uint8_t value, void *pending_of) {
    (void)address;
    struct pending *pending = pending_of;
    if (pending->dropped == chip->cycle && !(value & pending->flag)) avr_raise_interrupt(chip, pending->vector);
}

static void find_vector(struct pending *pending) {
    for (int i = 0; i < avr->interrupts.vector_count; i++)
        if (avr->interrupts.vector[i]->vector == pending->number) pending->vector = avr->interrupts.vector[i];
    if (!pending->vector) fail("simavr lacks an interrupt");
}

static void watch_pending(struct pending *pending) {
    find_vector(pending);
    avr_irq_register_notify(&pending->vector->irq[AVR_INT_IRQ_PENDING], note_pending, pending);
    avr_register_io_write(avr, TIFR4, keep_pending, pending);
}

/* The model's watchdog waits for its interrupt as long as interrupts are off, the chip's resets the chip then. */
static struct pending watchdog = {.number = 12};

static int bites;

static avr_cycle_count_t bite(avr_t *chip, avr_cycle_count_t when, void *unused) {
    (void)chip, (void)when, (void)unused;
    bites = watchdog.vector->pending;
    return 0;
}

static void note_watchdog(struct avr_irq_t *irq, uint32_t is_pending, void *unused) {
    (void)irq, (void)unused;
    if (is_pending) avr_cycle_timer_register_usec(avr, WATCHDOG_US, bite, NULL);
}

static void (*reset_of_core)(avr_t *);

static void note_reset(avr_t *chip) {
    if (reset_of_core) reset_of_core(chip);
    done.traces_before_reset = done.traces;
    if (hang.on) memcpy(chip->flash + hang.address, hang.code, 2);
    hang.on = 0;
    byte_cycles = 0;
    uplink.count = 0;
    display.halves = 0;
    writing.enabled = 0;
    wheels.edges[0] = wheels.edges[1] = 0;
    /* The timers that would end the echoes are gone. */
    for (int side = 0; side < 2; side++) set_pin('L', side, 0);
    for (int i = 0; i < 8; i++) avr_extint_set_strict_lvl_trig(chip, i, 0);
    avr_cycle_timer_register(chip, STEP_CYCLES, end_step, NULL);
}

static void watch_stack(void) {
    memset(avr->data + stack_bottom, PAINT, avr->ramend + 1 - stack_bottom);
}

static void reset(uint8_t reason) {
    avr_reset(avr);
    avr->data[MCUSR] = reason;
}

static void lose_power(void) {
    if (avr->cycle < writing.end) {
        uint8_t damaged = random_byte();
        avr_eeprom_desc_t byte = {.ee = &damaged, .offset = writing.address, .size = 1};
        avr_ioctl(avr, AVR_IOCTL_EEPROM_SET, &byte);
    }
    writing.end = 0;
    for (int address = RAM; address <= avr->ramend; address++) avr->data[address] = random_byte();
    watch_stack();
    reset(1);
}

/* Commands. */

static void step(void) {
    avr_cycle_count_t begin = avr->cycle, end = begin + STEP_CYCLES;
    for (int side = 0; side < 2; side++) {
        int edges = read_byte();
        if (edges && wheels.edges[side] == 0) {
            wheels.apart[side] = STEP_CYCLES / (edges + 1);
            avr_cycle_timer_register(avr, wheels.apart[side], turn_wheel, (void *)(intptr_t)side);
        }
        wheels.edges[side] += edges;
    }
    static const char ports[] = "CLK";
    static const int inputs[] = {0x26, 0x109, 0x106};
    /* PL0 and PL1 are the echoes. */
    static const uint8_t masks[] = {0xFF, 0xFC, 0xFF};
    for (int port = 0; port < 3; port++) {
        /* The model lets a pull-up win over the level of a pin. */
        uint8_t level = read_byte(), changed = (level ^ avr->data[inputs[port]]) & masks[port];
        for (int bit = 0; bit < 8; bit++)
            if (changed >> bit & 1) set_pin(ports[port], bit, level >> bit & 1);
    }
    for (int channel = 0; channel < 3; channel++)
        avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_ADC0 + channel), read_word(2));
    for (int count = read_byte(); count; count--) {
        uint8_t byte = read_byte();
        if (!byte_cycles || uplink.count == QUEUE) {
            lost_bytes++;
            continue;
        }
        uplink.bytes[(uplink.first + uplink.count) % QUEUE] = byte;
        if (!uplink.count++) {
            uint64_t wait = uplink.due > avr->cycle ? uplink.due - avr->cycle : 1;
            avr_cycle_timer_register(avr, wait, deliver, NULL);
        }
    }
    avr_cycle_timer_register(avr, STEP_CYCLES, end_step, NULL);
    while (avr->cycle < end) {
        int state = avr_run(avr);
        if (state == cpu_Done || state == cpu_Crashed) fail("the program stopped");
        if (bites) {
            bites = 0;
            avr_reset(avr);
            avr->data[MCUSR] = 8;
        }
        if (writing.is_lost) {
            writing.is_lost = 0;
            if (writing.reason == 1)
                lose_power();
            else
                reset(writing.reason);
        }
        /* The model counts 11 bits a byte. */
        if (uart->cycles_per_byte && uart->cycles_per_byte != byte_cycles)
            byte_cycles = uart->cycles_per_byte = uart->cycles_per_byte * 10 / 11;
    }
    uint32_t divisor = (avr->data[TCCR0B] & 7) == 3 ? 64 : 256;
    int has_tone = avr->data[TCCR0B] & 7 && avr->data[TCCR0A] & 0x10;
    int has_carrier = avr->data[TCCR2A] & 0x40 && (avr->data[TCCR2B] & 7) == 1;
    uint32_t carrier_hz = has_carrier ? avr->frequency / 2 / (avr->data[OCR2A] + 1) : 0;
    int has_pulses = pair(ICR3) + 1 == SERVO_COUNTS;
    putc(avr->data[OCR1A], answers);
    putc(avr->data[OCR1B], answers);
    putc(avr->data[PORTA], answers);
    putc(done.flags, answers);
    write_word(carrier_hz > 0xFFFF ? 0xFFFF : carrier_hz, 2);
    write_word(has_tone ? avr->frequency / 2 / divisor / (avr->data[OCR0A] + 1) : 0, 2);
    write_word(has_pulses ? (pair(OCR3A) + 1) / 2 : 0, 2);
    write_word(avr->cycle - begin - done.asleep, 2);
    write_word(done.sends, 2);
    fwrite(done.sent, 1, done.sends, answers);
    write_word(done.traces_before_reset, 2);
    write_word(done.traces, 2);
    fwrite(done.traced, 1, done.traces, answers);
    done.flags = done.sends = done.traces = done.asleep = 0;
    done.traces_before_reset = NO_RESET;
}

static void begin_hang(void) {
    static const uint8_t jump_to_itself[2] = {0xFF, 0xCF};
    avr->sreg[S_I] = read_byte() & 1;
    avr->state = cpu_Running;
    hang.address = avr->pc;
    memcpy(hang.code, avr->flash + avr->pc, 2);
    memcpy(avr->flash + avr->pc, jump_to_itself, 2);
    hang.on = 1;
}

static void write_figures(void) {
    uint32_t lowest = stack_bottom;
    while (lowest <= avr->ramend && avr->data[lowest] == PAINT) lowest++;
    write_word(avr->ramend + 1 - lowest, 2);
    write_word(lowest - stack_bottom, 2);
    write_word(lost_bytes, 2);
    write_word(byte_cycles ? avr->frequency * 10 / byte_cycles : 0, 2);
}

static void start(const char *program) {
    static elf_firmware_t firmware;
    if (elf_read_firmware(program, &firmware)) fail("cannot read the program");
    avr = avr_make_mcu_by_name("atmega2560");
    if (!avr) fail("simavr has no ATmega2560");
    avr_init(avr);
    avr->log = LOG_ERROR;
    avr->frequency = 16000000;
    avr->vcc = avr->avcc = avr->aref = 5000;
    avr->sleep = note_sleep;
    avr_load_firmware(avr, &firmware);
    /* The linker puts `.noinit` behind `.bss`, and the model counts neither it nor the paint. */
    stack_bottom = RAM + firmware.datasize + firmware.bsssize + 8;
    watch_stack();
    for (avr_io_t *io = avr->io_port; io; io = io->next)
        if (!strcmp(io->kind, "uart") && ((avr_uart_t *)io)->name == '1') uart = (avr_uart_t *)io;
    if (!uart) fail("simavr has no serial port 1");
    uint32_t flags = 0;
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('1'), &flags);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('1'), UART_IRQ_OUTPUT), note_sent, NULL);
    for (intptr_t side = 0; side < 2; side++)
        avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('A'), 4 + side), note_trigger,
                                (void *)(side + 1));
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('H'), 1), note_display, NULL);
    watch_pending(&clock_a);
    watch_pending(&capture_4);
    find_vector(&watchdog);
    avr_irq_register_notify(&watchdog.vector->irq[AVR_INT_IRQ_PENDING], note_watchdog, NULL);
    avr_register_io_write(avr, GPIOR1, note_trace, NULL);
    avr_register_io_write(avr, EECR, write_eecr, NULL);
    avr_register_io_read(avr, EECR, read_eecr, NULL);
    reset_of_core = avr->reset;
    avr->reset = note_reset;
    reset(1);
    done.traces_before_reset = NO_RESET;
}

int main(int count, char **arguments) {
    /* simavr prints messages to standard output. */
    answers = fdopen(dup(STDOUT_FILENO), "w");
    if (count != 2 || !answers || !freopen("/dev/null", "w", stdout)) {
        fprintf(stderr, "usage: board PROGRAM.elf < COMMANDS > ANSWERS\n");
        return 2;
    }
    start(arguments[1]);
    for (int command; (command = getchar()) != EOF; fflush(answers)) {
        switch (command) {
        case 'S': step(); break;
        case 'E': {
            int side = read_byte() & 1;
            echo_us[side] = read_word(4);
            avr_cycle_timer_register_usec(avr, BEFORE_ECHO_US, begin_echo, (void *)(intptr_t)side);
            break;
        }
        case 'P': lose_power(); break;
        case 'W': writing.to_loss = read_word(2); writing.reason = read_byte(); break;
        case 'B': reset(4); break;
        case 'H': begin_hang(); break;
        case 'X': avr->pc = read_word(4); avr->state = cpu_Running; break;
        case 'L': fwrite(display.text, 1, sizeof display.text, answers); break;
        case 'F': write_figures(); break;
        default: fail("an unknown command");
        }
    }
    return 0;
}
