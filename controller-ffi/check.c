/* The Rust library and the exported C on the same inputs. The C source is included for its tables. */
#include "../controller/examples/rats_planar/saltus_controller.c"

#include <stdio.h>

#include "drill.h"
#include "saltus_controller_ffi.h"

static SaltusAxis axis_of(axis a) {
    SaltusAxis out = {a.first, a.last, a.per_unit, a.count};
    return out;
}

int main(void) {
    SaltusController c = {
        .rates = axis_of(map_rates), .distances = axis_of(table_distances), .angles = axis_of(map_angles),
        .table_nodes = rule_nodes, .table_open = rule_open, .map_nodes = map_nodes, .map_open = map_open,
        .radius = radius, .gravity = gravity, .pendulum = pendulum, .reference_lean = reference_lean, .stride = stride,
        .least_rate = least_rate, .greatest_rate = greatest_rate, .at_firing = AT_FIRING,
        .valve_open = nominal_valve_open, .landing_height = landing_height, .period = period, .extra_delay = extra_delay,
        .least_valve_open = least_valve_open, .greatest_valve_open = greatest_valve_open, .effort = effort, .newton_steps = NEWTON_STEPS,
    };
    int answered = 0;
    drill_begin(1);
    for (int k = 0; k < 100000; k++) {
        drill_decision d;
        saltus_decision ours;
        SaltusDecision theirs;
        drill_decision_input(&d);
        SaltusSensed sensed = {d.sensed.lean, d.sensed.rate};
        SaltusObstacle o = {d.obstacle.front, d.obstacle.back, d.obstacle.height, d.obstacle.clearance};
        SaltusTask task = {d.task.distance, d.task.landing_height, d.task.obstacle ? &o : NULL, NULL};
        int status = (int)saltus_decide(&d.sensed, &d.task, &ours);
        if (status != (int)saltus_controller_decide(&c, &sensed, &task, &theirs)) return 1;
        if (status != SALTUS_OK) continue;
        answered++;
        if (ours.approach_rate != theirs.approach_rate || ours.firing_angle != theirs.firing_angle) return 2;
        if (ours.valve_open != theirs.valve_open || ours.time != theirs.time) return 3;
        if ((int)ours.timing != (int)theirs.timing || ours.settled != theirs.settled) return 4;
    }
    for (int k = 0; k < 10000; k++) {
        drill_decision d;
        float ours, theirs;
        drill_decision_input(&d);
        int status = (int)saltus_firing_angle(d.sensed.rate, d.task.distance, d.task.landing_height, &ours);
        if (status != (int)saltus_controller_firing_angle(&c, d.sensed.rate, d.task.distance, d.task.landing_height, &theirs)) return 12;
        if (status == SALTUS_OK && ours != theirs) return 13;
        answered += status == SALTUS_OK;
    }
    for (int k = 0; k < 1000; k++) {
        saltus_approach a;
        saltus_take_off ours;
        SaltusTakeOff theirs;
        drill_approach_input(&a);
        SaltusApproach b = {a.distance, a.height, a.length, a.speed, a.clearance};
        enum saltus_input input;
        SaltusInput which;
        if (k % 7 == 0) b.height = a.height = -1.0f;
        int status = (int)saltus_choose_take_off(&a, &ours, &input);
        if (status != (int)saltus_controller_take_off(&c, &b, &theirs, &which) || (int)input != (int)which) return 5;
        if (status != SALTUS_OK) continue;
        answered++;
        if (ours.touch_down != theirs.touch_down || ours.firing_angle != theirs.firing_angle) return 6;
    }
    for (int k = 0; k < 10000; k++) {
        drill_program p;
        SaltusHalfPlane planes[DRILL_CONSTRAINTS];
        float ours[2], theirs[2];
        drill_program_input(&p);
        for (int j = 0; j < DRILL_CONSTRAINTS; j++) {
            SaltusHalfPlane plane = {{p.constraints[j].normal[0], p.constraints[j].normal[1]}, p.constraints[j].bound};
            planes[j] = plane;
        }
        int status = (int)saltus_qp2(p.h, p.g, p.constraints, DRILL_CONSTRAINTS, ours);
        if (status != (int)saltus_controller_qp2(&p.h, &p.g, planes, DRILL_CONSTRAINTS, &theirs)) return 7;
        if (status == SALTUS_OK && (ours[0] != theirs[0] || ours[1] != theirs[1])) return 8;
        answered += status == SALTUS_OK;
    }
    if (saltus_controller_decide(NULL, NULL, NULL, NULL) != SaltusStatus_SensorInvalid) return 9;
    SaltusSensed state = {-0.3f, 4.0f};
    saltus_sensed same = {-0.3f, 4.0f};
    saltus_controller_observe(&state, -0.29f, pendulum, period, 0.9f);
    saltus_observe(&same, -0.29f, period, 0.9f);
    if (state.lean != same.lean || state.rate != same.rate) return 10;
    printf("Rust library and exported C agree to the bit: %d answers\n", answered);
    return answered > 10000 ? 0 : 11;
}
