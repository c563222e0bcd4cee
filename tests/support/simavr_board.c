/* Runs the board's firmware in simavr, as far as it is told to, and reports the edges of its pins.
 *
 * usage: simavr_board FIRMWARE.elf
 * It prints the path of the pseudo-terminal that is the board's UART. Each line of standard input is
 * a cycle to run to; each answer is the edges since ("P" pulse or "L" light, cycle, level), and "=".
 */
#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <stdio.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>

static avr_t *avr;
static avr_irq_t *input;
static int far_end;
static int paused;
static FILE *report; /* simavr itself writes to standard output */

static void on_edge(struct avr_irq_t *irq, uint32_t value, void *name)
{
    (void)irq;
    fprintf(report, "%s %llu %u\n", (const char *)name, (unsigned long long)avr->cycle, value & 1);
}

static void on_byte(struct avr_irq_t *irq, uint32_t value, void *unused)
{
    (void)irq, (void)unused;
    unsigned char byte = (unsigned char)value;
    if (write(far_end, &byte, 1) != 1)
        exit(2);
}

static void on_xon(struct avr_irq_t *irq, uint32_t value, void *unused)
{
    (void)irq, (void)value, (void)unused;
    paused = 0;
}

static void on_xoff(struct avr_irq_t *irq, uint32_t value, void *unused)
{
    (void)irq, (void)value, (void)unused;
    paused = 1;
}

static void feed(void)
{
    unsigned char byte;
    while (!paused && read(far_end, &byte, 1) == 1)
        avr_raise_irq(input, byte);
}

int main(int argc, char **argv)
{
    elf_firmware_t firmware = {0};
    int near_end;
    char name[64], line[64];
    report = fdopen(dup(1), "w");
    dup2(2, 1);
    if (argc != 2 || elf_read_firmware(argv[1], &firmware) != 0)
        return 2;
    avr = avr_make_mcu_by_name("atmega328p");
    if (!avr || avr_init(avr) != 0 || openpty(&far_end, &near_end, name, NULL, NULL) != 0)
        return 2;
    avr_load_firmware(avr, &firmware);
    avr->frequency = 16000000;
    avr->log = LOG_ERROR;

    struct termios mode;
    tcgetattr(near_end, &mode);
    cfmakeraw(&mode);
    tcsetattr(near_end, TCSANOW, &mode);
    fcntl(far_end, F_SETFL, O_NONBLOCK);

    uint32_t flags = 0;
    avr_ioctl(avr, AVR_IOCTL_UART_GET_FLAGS('0'), &flags);
    flags &= ~(uint32_t)(AVR_UART_FLAG_STDIO | AVR_UART_FLAG_POLL_SLEEP);
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    input = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
    avr_irq_register_notify(
        avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), on_byte, NULL);
    avr_irq_register_notify(
        avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XON), on_xon, NULL);
    avr_irq_register_notify(
        avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XOFF), on_xoff, NULL);
    avr_irq_register_notify(
        avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('B'), 1), on_edge, (void *)"P");
    avr_irq_register_notify(
        avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('B'), 3), on_edge, (void *)"L");

    fprintf(report, "%s\n", name);
    fflush(report);
    while (fgets(line, sizeof line, stdin)) {
        unsigned long long until = strtoull(line, NULL, 10);
        feed();
        while (avr->cycle < until) {
            int how = avr_run(avr);
            if (how == cpu_Done || how == cpu_Crashed)
                return 3;
            if (!(avr->cycle & 0x3F))
                feed();
        }
        fprintf(report, "=\n");
        fflush(report);
    }
    return 0;
}
