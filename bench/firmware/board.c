/* Firmware of the bench's board: ATmega328P at 16 MHz (Arduino Uno, Nano and their copies).
 *
 *   pin 9  (PB1, OC1A)  pulses for the servo
 *   pin 11 (PB3, OC2A)  the coded light: LED and 330 ohm to ground
 *   USB                 115200 bit/s; packets as in bench/servo/codecs/board.py
 *
 * Timer 1 makes the pulses in hardware, 0.5 us a tick: it counts the pulse, then the pause, its
 * output follows each match (CTC mode), and the interrupt of one edge sets the length of what follows,
 * so that no interrupt moves an edge. Timer 2 makes the light the same way, a match each millisecond;
 * the interrupt of the millisecond before has chosen the level. Both timers run on the same crystal,
 * and the first bit starts with the first pulse of a command.
 *
 * The host sets limits once (SETUP, while there are no pulses). Whatever it sends afterwards, no pulse
 * leaves them, nor differs from the one before by more than a step. Without a packet for `silence`
 * pulse periods the board moves the servo to neutral and stops the pulses; if the program itself
 * hangs, the chip's watchdog resets it, and the pulses end.
 */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/wdt.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

enum { START = 0xA5, ANSWER = 0x80, VERSION = 1, BUFFER = 512, LONGEST = 64 };
enum { HELLO = 1, SETUP, SET, SAMPLES, PLAY, STATUS, STOP };
enum { IDLE, ARMED, PLAYING, RELEASING };
enum { STARVED = 1, LINK_LOST = 2, REFUSED = 4 };

#define PERIOD_MIN 8000u /* 4 ms */
#define PERIOD_MAX 64000u
#define WIDTH_MIN 800u   /* 400 us */
#define WIDTH_MAX 5200u  /* 2600 us */
#define MS 2000u         /* ticks of a millisecond */
#define LIGHT_COUNTS 250 /* of 4 us: a match a millisecond */
#define BIT_MS 37
#define GAP 15000u        /* turns of the main loop without a byte: 10 to 20 ms */

struct setup {
    uint16_t period, low, high, neutral, step, ramp, silence;
};

struct status {
    uint8_t state, flags;
    uint32_t period;
    uint16_t tick;
    uint32_t began, played, expected;
    uint16_t free, width;
} __attribute__((packed));

static struct setup setup;
static volatile bool configured;
static volatile uint8_t state, flags;
static volatile uint16_t width, target, silent;
static volatile uint32_t period, began, played, expected, total;
static volatile bool starting, high;
static volatile uint16_t span; /* ticks of the last pulse, or of what stands for it */
static uint16_t buffer[BUFFER];

static volatile bool light_on;
static volatile uint8_t light_wait, light_ms;
static volatile uint16_t light_bits;

/* ---- the light ---------------------------------------------------------------------------- */

/* At its next match timer 2 sets (on) or clears (off) its output. */
static inline void light_next(bool on)
{
    TCCR2A = (uint8_t)(_BV(COM2A1) | (on ? _BV(COM2A0) : 0) | _BV(WGM21));
}

/* Let bit 0 start `left` ticks from the last edge of a pulse on. A period has whole milliseconds and
 * both timers started together, so a match of timer 2 falls there. */
static inline void light_start(uint16_t left)
{
    light_bits = 0x3FF;
    light_ms = BIT_MS - 1;
    light_wait = (uint8_t)((left - 1u) / MS);
    light_next(light_wait == 0);
    light_on = true;
}

ISR(TIMER2_COMPA_vect)
{
    if (!light_on) {
        light_next(false);
        return;
    }
    if (light_wait) {
        if (--light_wait == 0)
            light_next(true);
        return;
    }
    if (++light_ms >= BIT_MS)
        light_ms = 0;
    if (light_ms == BIT_MS - 1) {
        uint16_t bits = light_bits;
        bits = (uint16_t)(bits >> 1 | ((bits ^ bits >> 3) & 1u) << 9);
        light_bits = bits;
        light_next(bits & 1u);
    }
}

/* ---- the pulses --------------------------------------------------------------------------- */

static inline uint16_t towards(uint16_t from, uint16_t to, uint16_t step)
{
    if (to > from && to - from > step)
        return (uint16_t)(from + step);
    if (to < from && from - to > step)
        return (uint16_t)(from - step);
    return to;
}

static inline void pulses_off(void)
{
    state = IDLE;
    width = 0;
    light_on = false;
}

/* The next sample of the command, or the end of it. */
static inline void next_sample(void)
{
    if (played == total || played == expected) {
        if (played != total)
            flags |= STARVED;
        state = ARMED;
        light_on = false;
        return;
    }
    if (starting) {
        starting = false;
        began = period + 1;
        light_start((uint16_t)(setup.period - span));
    }
    target = buffer[played % BUFFER];
    played++;
}

/* Choose the width of the next pulse. */
static inline void next_pulse(void)
{
    if (state == IDLE)
        return;
    if (state != RELEASING && ++silent > setup.silence) {
        flags |= LINK_LOST;
        state = RELEASING;
        light_on = false;
    }
    if (state == PLAYING)
        next_sample();
    if (state == RELEASING) {
        if (width == setup.neutral)
            pulses_off();
        else
            width = towards(width, setup.neutral, setup.ramp);
    } else {
        uint16_t goal = target;
        goal = goal < setup.low ? setup.low : goal > setup.high ? setup.high : goal;
        width = towards(width, goal, setup.step);
    }
}

/* An edge has just been made: say when and how the next one is. Without pulses time goes on. */
ISR(TIMER1_COMPA_vect)
{
    high = !high;
    if (high) {
        period++;
        span = width ? width : WIDTH_MIN;
        OCR1A = span - 1u;
        TCCR1A = width ? _BV(COM1A1) : 0;
    } else {
        OCR1A = setup.period - span - 1u;
        next_pulse();
        TCCR1A = width ? _BV(COM1A1) | _BV(COM1A0) : 0;
    }
}

/* Ticks since the last period began; with interrupts off. */
static uint16_t ticks(uint32_t *periods)
{
    uint16_t tick = TCNT1;
    bool pending = (TIFR1 & _BV(OCF1A)) && tick < 0x2000u; /* an edge without its interrupt */
    bool in_pulse = high != pending;
    *periods = period + (pending && in_pulse);
    return in_pulse ? tick : (uint16_t)(tick + span);
}

/* Both timers from zero at the same moment; the first pulse is due a millisecond later. */
static void timers_start(void)
{
    DDRB |= _BV(PB1) | _BV(PB3);
    high = false;
    span = WIDTH_MIN;
    GTCCR = _BV(TSM) | _BV(PSRASY) | _BV(PSRSYNC);
    TCCR1A = 0;
    TCCR1B = _BV(WGM12) | _BV(CS11);
    OCR1A = MS - 1u;
    OCR2A = LIGHT_COUNTS - 1;
    light_next(false);
    TCCR2B = _BV(CS22);
    TCNT1 = 0;
    TCNT2 = 0;
    GTCCR = 0;
    TIFR1 = _BV(OCF1A);
    TIFR2 = _BV(OCF2A);
    TIMSK1 = _BV(OCIE1A);
    TIMSK2 = _BV(OCIE2A);
}

/* ---- packets ------------------------------------------------------------------------------ */

static uint16_t crc16(const uint8_t *data, uint8_t size, uint16_t crc)
{
    while (size--) {
        crc ^= (uint16_t)(*data++ << 8);
        for (uint8_t i = 0; i < 8; i++)
            crc = crc & 0x8000u ? (uint16_t)(crc << 1 ^ 0x8005u) : (uint16_t)(crc << 1);
    }
    return crc;
}

static void put(uint8_t byte)
{
    while (!(UCSR0A & _BV(UDRE0)))
        ;
    UDR0 = byte;
}

static void answer(uint8_t code, const void *payload, uint8_t size)
{
    uint8_t head[3] = {START, size, code | ANSWER};
    uint16_t crc = crc16(payload, size, crc16(head, 3, 0));
    for (uint8_t i = 0; i < 3; i++)
        put(head[i]);
    for (uint8_t i = 0; i < size; i++)
        put(((const uint8_t *)payload)[i]);
    put((uint8_t)crc);
    put((uint8_t)(crc >> 8));
}

static void refuse(void) { flags |= REFUSED; }

static void take_setup(const uint8_t *payload)
{
    struct setup s;
    memcpy(&s, payload, sizeof s);
    bool whole = s.period >= PERIOD_MIN && s.period <= PERIOD_MAX && s.period % MS == 0 && s.low >= WIDTH_MIN
        && s.high <= WIDTH_MAX && s.high + 1000u < s.period && s.low <= s.neutral
        && s.neutral <= s.high && s.step && s.ramp && s.silence;
    if (!whole || (state != IDLE && memcmp(&s, &setup, sizeof s))) {
        refuse();
        return;
    }
    if (state != IDLE)
        return; /* the same once more: its answer was lost */
    setup = s;
    configured = true;
    flags = 0;
    played = expected = total = 0;
    timers_start();
}

static void take_target(uint16_t goal)
{
    if (!configured || state == PLAYING || state == RELEASING) {
        refuse();
        return;
    }
    target = goal;
    if (state == IDLE) {
        width = setup.neutral; /* nobody knows where the servo stands */
        silent = 0;
        state = ARMED;
    }
}

static void take_samples(const uint8_t *payload, uint8_t size)
{
    uint32_t first;
    memcpy(&first, payload, 4);
    for (uint8_t i = 0; 4 + 2 * i < size; i++) {
        cli();
        bool room = expected - played < BUFFER;
        sei();
        if (first + i == expected && room) {
            memcpy(&buffer[expected % BUFFER], payload + 4 + 2 * i, 2);
            cli();
            expected++;
            sei();
        }
    }
}

static void take_play(uint32_t end)
{
    if (state == ARMED && end > played && expected > played) {
        total = end;
        starting = true;
        state = PLAYING;
    } else if (!(end == total)) { /* the same once more is no error */
        refuse();
    }
}

static void take(uint8_t code, const uint8_t *payload, uint8_t size)
{
    struct status s;
    cli();
    silent = 0;
    uint32_t periods;
    s.tick = ticks(&periods);
    s.period = periods;
    sei();
    if (code == HELLO) {
        const uint8_t about[] = {VERSION, BUFFER & 0xFF, BUFFER >> 8};
        answer(code, about, sizeof about);
        return;
    }
    cli();
    if (code == SETUP && size == sizeof(struct setup))
        take_setup(payload);
    else if (code == SET && size == 2)
        take_target((uint16_t)(payload[0] | payload[1] << 8));
    else if (code == PLAY && size == 4) {
        uint32_t end;
        memcpy(&end, payload, 4);
        take_play(end);
    } else if (code == STOP && state != IDLE)
        state = RELEASING, light_on = false;
    sei();
    if (code == SAMPLES && size > 4)
        take_samples(payload, size);
    cli();
    s.state = state;
    s.flags = flags;
    s.began = began;
    s.played = played;
    s.expected = expected;
    s.free = (uint16_t)(BUFFER - (expected - played));
    s.width = width;
    sei();
    answer(code, &s, sizeof s);
}

static uint8_t packet[LONGEST + 5];
static uint8_t count;

/* One byte of the line: START, size, code, payload, CRC. */
static void receive(uint8_t byte)
{
    if (count == 0 && byte != START)
        return;
    packet[count++] = byte;
    if (count >= 2 && packet[1] > LONGEST)
        count = 0;
    if (count < 5 || count < packet[1] + 5)
        return;
    count = 0;
    uint8_t size = packet[1];
    uint16_t crc = crc16(packet, (uint8_t)(size + 3), 0);
    if (packet[size + 3] == (uint8_t)crc && packet[size + 4] == (uint8_t)(crc >> 8))
        take(packet[2], packet + 3, size);
}

int main(void)
{
    uint16_t idle = 0;
    MCUSR = 0;
    wdt_enable(WDTO_250MS);
    UCSR0A = _BV(U2X0);
    UBRR0 = 16; /* 115200 bit/s at 16 MHz, 2.1 % fast */
    UCSR0B = _BV(RXEN0) | _BV(TXEN0);
    UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
    sei();
    for (;;) {
        wdt_reset();
        if (UCSR0A & _BV(RXC0)) {
            receive(UDR0);
            idle = 0;
        } else if (++idle == GAP) {
            count = 0; /* what is missing was lost: the next byte begins a packet */
        }
    }
}
