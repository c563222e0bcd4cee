#include <stdio.h>

/* Cases from the standard input, all doubles: the parameters, the command's samples; angles out. */
int main(int argc, char **argv)
{
    static fin_model servo;
    static double row[FIN_PARAMETERS], command[1 << 16];
    const size_t samples = (size_t)(argc > 1 ? strtol(argv[1], NULL, 10) : 0);
    const double period_s = argc > 2 ? strtod(argv[2], NULL) : 0.0;
    if (fread(command, sizeof(double), samples, stdin) != samples) return 1;
    while (fread(row, sizeof(double), FIN_PARAMETERS, stdin) == FIN_PARAMETERS) {
        double angle;
        fin_defaults(&servo);
        for (int i = 0; i < FIN_PARAMETERS; ++i) {
            if (fin_set(&servo, i, row[i]) != FIN_OK) return 2;
        }
        fin_start(&servo, row[4], row[5]);
        angle = fin_angle(&servo);
        fwrite(&angle, sizeof(double), 1, stdout);
        for (size_t i = 0; i < samples; ++i) {
            if (fin_step(&servo, command[i], period_s) != FIN_OK) return 3;
            angle = fin_angle(&servo);
            fwrite(&angle, sizeof(double), 1, stdout);
        }
    }
    return 0;
}
