/*
 * The exported headers on a Cortex-M4 without operating system or C library: 10^5 samples in single precision, double
 * precision and integers. Prints the largest differences from double precision, and a sum over all bits of the results.
 */
#include <stdint.h>

#include "integer.h"
#include "real.h"
#include "single.h"

extern uint32_t stack_top;
int main(void);

/* Output through the debugger: write a text that ends in zero; end with success or failure. */
static int32_t semihosting(int32_t operation, const void *argument)
{
    register int32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static void finish(int failed)
{
    semihosting(0x18, (const void *)(failed ? 0x20024 : 0x20026));
    for (;;) {
    }
}

void reset(void)
{
    /* The floating-point unit is off after reset. */
    *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20;
    __asm__ volatile("dsb\nisb");
    finish(main());
}

static void fault(void)
{
    finish(1);
}

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    &stack_top, (void *)reset, (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault,
};

static void hexadecimal(const char *name, uint32_t high, uint32_t low)
{
    char text[64];
    int n = 0, i;
    while (*name)
        text[n++] = *name++;
    text[n++] = ' ';
    for (i = 28; i >= 0; i -= 4)
        text[n++] = "0123456789abcdef"[(high >> i) & 15];
    for (i = 28; i >= 0; i -= 4)
        text[n++] = "0123456789abcdef"[(low >> i) & 15];
    text[n++] = '\n';
    text[n] = 0;
    semihosting(4, text);
}

static uint64_t state; /* begins at 11: nothing copies initial values into memory here */

static uint32_t below(uint32_t n)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(state >> 33) % n;
}

union bits {
    double number;
    uint64_t bits;
};

static void print(const char *name, double number)
{
    union bits b;
    b.number = number;
    hexadecimal(name, (uint32_t)(b.bits >> 32), (uint32_t)b.bits);
}

int main(void)
{
    double worst_single = 0, worst_integer = 0;
    uint64_t sum_real = 0;
    uint32_t sum_integer = 0;
    int i, axis;
    state = 11;
    if (single_self_check() || real_self_check() || integer_self_check())
        return 1;
    for (i = 0; i < 100000; i++) {
        int32_t output[3], a[3], t;
        float f[3], af[3];
        double d[3], ad[3];
        for (axis = 0; axis < 3; axis++) {
            output[axis] = (int32_t)below(65536);
            f[axis] = (float)output[axis];
            d[axis] = (double)output[axis];
        }
        t = (int32_t)below(32000) - 10240;
        if (!integer_apply(output, t, a) || !single_apply(f, (float)t / 256, af) || !real_apply(d, (double)t / 256, ad))
            return 1;
        for (axis = 0; axis < 3; axis++) {
            union bits b;
            double e = (double)af[axis] - ad[axis];
            if (e < 0)
                e = -e;
            if (e > worst_single)
                worst_single = e;
            e = (double)a[axis] / (double)(INT32_C(1) << INTEGER_RESULT_BITS) - ad[axis];
            if (e < 0)
                e = -e;
            if (e > worst_integer)
                worst_integer = e;
            b.number = ad[axis];
            sum_real = sum_real * 31 + b.bits;
            sum_integer = sum_integer * 31 + (uint32_t)a[axis];
        }
    }
    print("single", worst_single);
    print("integer", worst_integer);
    hexadecimal("real", (uint32_t)(sum_real >> 32), (uint32_t)sum_real);
    hexadecimal("bits", 0, sum_integer);
    return 0;
}
