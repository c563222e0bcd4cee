#include <stdio.h>

int main(void)
{
    static @name@_model servo;
    double start_deg, command_deg, duration_s;
    if (scanf("%lf", &start_deg) != 1) return 1;
    @name@_defaults(&servo);
    @name@_start(&servo, start_deg, 0.0);
    printf("%.17g\n", @name@_angle(&servo));
    while (scanf("%lf %lf", &command_deg, &duration_s) == 2) {
        if (@name@_step(&servo, command_deg, duration_s) != @NAME@_OK) return 1;
        printf("%.17g\n", @name@_angle(&servo));
    }
    return 0;
}
