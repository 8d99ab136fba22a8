/*
 * A robot's loop at 1 kHz around the exported code: each millisecond it reads the encoder, follows the wheel, decides, and opens the valve.
 *
 * Here the robot is the multi-body simulation, at the other end of two pipes: `cd studies && cargo run --release --bin in_the_loop --
 * 200 ../robot`. On a robot, read_lean would be an encoder's counter and open_valve a timer's compare register.
 *
 *     cc -std=c99 -O2 -fno-math-errno -Irats_planar robot.c rats_planar/saltus_controller.c -lm -o robot
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "saltus_controller.h"

#define PERIOD 1e-3f
#define MEMORY 0.9f

int main(int argc, char **argv) {
    saltus_task task = {argc > 1 ? strtof(argv[1], NULL) : 0.4f, 0.24f, NULL, NULL};
    saltus_sensed state = {0.0f, 0.0f};
    char line[128];
    if (saltus_self_test() != 0) {
        fprintf(stderr, "robot: the tables are damaged, or this compiler computes otherwise\n");
        return 1;
    }
    while (fgets(line, sizeof line, stdin)) {
        if (strncmp(line, "start ", 6) == 0) { /* touch-down: the approach rate, and the lean there */
            char *end;
            state.rate = strtof(line + 6, &end);
            state.lean = strtof(end, NULL);
            continue;
        }
        saltus_observe(&state, strtof(line, NULL), PERIOD, MEMORY);
        saltus_decision decision;
        enum saltus_status status = saltus_decide(&state, &task, &decision);
        if (status == SALTUS_OK && decision.timing == SALTUS_FIRE) {
            printf("fire %.9g %.9g\n", (double)decision.time, (double)decision.valve_open);
        } else if (status == SALTUS_OK && decision.timing == SALTUS_LATE) {
            printf("fire 0 %.9g\n", (double)decision.valve_open);
        } else {
            printf("wait\n");
        }
        fflush(stdout);
    }
    return 0;
}
