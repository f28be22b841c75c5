/*
 * Compensates readings with an exported header: outputs and temperature in, accelerations out.
 *
 *   proofmass export calibration.json --c --name accelerometer -o accelerometer.h
 *   cc -std=c99 accelerometer.c -o accelerometer
 *   echo "33120 33271 36436 21.5" | ./accelerometer
 */
#include <stdio.h>

#include "accelerometer.h"

int main(void)
{
    float output[3], temperature, a[3];
    if (accelerometer_self_check() != 0) {
        fprintf(stderr, "this compiler does not compute what the desk computed\n");
        return 1;
    }
    while (scanf("%f %f %f %f", &output[0], &output[1], &output[2], &temperature) == 4) {
        const int within = accelerometer_apply(output, temperature, a);
        printf("%.9g %.9g %.9g%s\n", a[0], a[1], a[2], within ? "" : " extrapolated");
    }
    return 0;
}
