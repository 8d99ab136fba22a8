// The Rust controller for programs in C. Written by cbindgen from controller-ffi/src/lib.rs; the test `header` does it again.

#ifndef SALTUS_CONTROLLER_FFI_H
#define SALTUS_CONTROLLER_FFI_H

#include <stddef.h>
#include <stdint.h>
#include <stdbool.h>

// Most constraints of a quadratic program.
#define SALTUS_MOST_CONSTRAINTS 16

// A value, or the reason why there is none.
typedef enum SaltusStatus {
  // A value.
  SaltusStatus_Ok = 0,
  // Outside what the tables were made for.
  SaltusStatus_OutOfTable = 1,
  // Inside, but no jump does what is asked.
  SaltusStatus_Infeasible = 2,
  // A number that is no measurement, or a pointer that points nowhere.
  SaltusStatus_SensorInvalid = 3,
  // Take-off: the obstacle is too far yet; ask again at the next touch-down.
  SaltusStatus_AskLater = 4,
} SaltusStatus;

// When to command the valve, counted from the reading.
typedef enum SaltusTiming {
  // Not within this control period, but after the time.
  SaltusTiming_Wait = 0,
  // Within this control period, the time after the reading.
  SaltusTiming_Fire = 1,
  // The instant passed by the time.
  SaltusTiming_Late = 2,
} SaltusTiming;

// Which number of a [`SaltusApproach`] there is no take-off for.
typedef enum SaltusInput {
  // None of them alone: no jump clears this obstacle.
  SaltusInput_None = 0,
  // The distance.
  SaltusInput_Distance = 1,
  // The height.
  SaltusInput_Height = 2,
  // The length.
  SaltusInput_Length = 3,
  // The speed.
  SaltusInput_Speed = 4,
  // The clearance.
  SaltusInput_Clearance = 5,
} SaltusInput;

// Evenly spaced nodes.
typedef struct SaltusAxis {
  // The first node.
  float first;
  // The last node.
  float last;
  // Nodes in a unit.
  float per_unit;
  // How many nodes.
  uint32_t count;
} SaltusAxis;

// What a robot decides by: tables as `saltus export` writes them.
typedef struct SaltusController {
  // Rates (rad/s) of table and map, at the reference lean.
  struct SaltusAxis rates;
  // Distances (m) of the table.
  struct SaltusAxis distances;
  // Firing angles (rad) of the map.
  struct SaltusAxis angles;
  // The table: four numbers a node, as many nodes as rates times distances.
  const float (*table_nodes)[4];
  // Its cells.
  const uint8_t *table_open;
  // The map: twenty numbers a node, as many nodes as rates times angles.
  const float (*map_nodes)[20];
  // Its cells.
  const uint8_t *map_open;
  // Foot to wheel centre (m).
  float radius;
  // At the axle (m/s²).
  float gravity;
  // m g r/(I + m r²) (1/s²).
  float pendulum;
  // Lean (rad) at which the rates of table and map count.
  float reference_lean;
  // Least approach rate (rad/s).
  float least_rate;
  // Greatest approach rate (rad/s).
  float greatest_rate;
  // Whether approach rates count at the firing angle; else at the reference lean.
  bool at_firing;
  // From one touch-down to the next (m).
  float stride;
  // Valve opening time (s) of the tables.
  float valve_open;
  // Of the wheel's centre (m).
  float landing_height;
  // Control period (s).
  float period;
  // Of the valve, beyond the robot file's (s).
  float extra_delay;
  // Least valve opening time (s).
  float least_valve_open;
  // Greatest valve opening time (s).
  float greatest_valve_open;
  // Cost of a squared second of open valve (m²/s²).
  float effort;
  // Newton steps, 0 to 3.
  uint8_t newton_steps;
} SaltusController;

// Lean (rad) and lean rate (rad/s) of the loaded leg.
typedef struct SaltusSensed {
  // Lean (rad).
  float lean;
  // Its rate (rad/s).
  float rate;
} SaltusSensed;

// A box on the ground.
typedef struct SaltusObstacle {
  // From the foot to its front (m).
  float front;
  // From the foot to its back (m).
  float back;
  // Its height (m).
  float height;
  // Least distance of the wheel to keep (m).
  float clearance;
} SaltusObstacle;

// Firing angle (rad) and valve opening time (s) to start from.
typedef struct SaltusGuess {
  // Firing angle (rad).
  float firing_angle;
  // Valve opening time (s).
  float valve_open;
} SaltusGuess;

// What is wanted of a jump.
typedef struct SaltusTask {
  // Distance (m) from the foot to the landing.
  float distance;
  // Height of the wheel's centre there (m).
  float landing_height;
  // What is to be cleared; or null.
  const struct SaltusObstacle *obstacle;
  // Over an obstacle, the last decision on the same jump; or null.
  const struct SaltusGuess *guess;
} SaltusTask;

// A firing decision.
typedef struct SaltusDecision {
  // Approach rate (rad/s), counted as `at_firing` says.
  float approach_rate;
  // Firing angle (rad).
  float firing_angle;
  // Valve opening time (s).
  float valve_open;
  // Time (s) of `timing`.
  float time;
  // When to command the valve.
  enum SaltusTiming timing;
  // Whether the jump clears what it should.
  bool settled;
} SaltusDecision;

// A running robot before an obstacle.
typedef struct SaltusApproach {
  // From the next touch-down's foot to the obstacle's front (m).
  float distance;
  // Height of the obstacle (m).
  float height;
  // Its length along the travel (m).
  float length;
  // Running speed of the axle (m/s).
  float speed;
  // Least distance to keep (m).
  float clearance;
} SaltusApproach;

// Where and how to take off.
typedef struct SaltusTakeOff {
  // From which touch-down; 0 is the next.
  uint32_t touch_down;
  // Approach rate (rad/s).
  float approach_rate;
  // Firing angle (rad).
  float firing_angle;
  // From that touch-down's foot to the landing (m).
  float distance;
  // What the jump keeps (m).
  float clearance;
} SaltusTakeOff;

// normal · x ≤ bound.
typedef struct SaltusHalfPlane {
  // a.
  float normal[2];
  // b.
  float bound;
} SaltusHalfPlane;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Whether and when to open the valve now, and how long for.
//
// # Safety
// Each pointer is null or points to what its type says, tables as large as their axes say; `decision` may be written.
enum SaltusStatus saltus_controller_decide(const struct SaltusController *controller,
                                           const struct SaltusSensed *sensed,
                                           const struct SaltusTask *task,
                                           struct SaltusDecision *decision);

// The firing angle (rad) for an approach rate (rad/s), a distance (m) and a landing height (m).
//
// # Safety
// As [`saltus_controller_decide`].
enum SaltusStatus saltus_controller_firing_angle(const struct SaltusController *controller,
                                                 float rate,
                                                 float distance,
                                                 float height,
                                                 float *angle);

// From which of the next four touch-downs to jump, and at which angle; `input` says which number there is no take-off for.
//
// # Safety
// As [`saltus_controller_decide`]; `input` is null or may be written.
enum SaltusStatus saltus_controller_take_off(const struct SaltusController *controller,
                                             const struct SaltusApproach *approach,
                                             struct SaltusTakeOff *take_off,
                                             enum SaltusInput *input);

// Minimises x' H x/2 + g' x under at most 16 constraints; `h` points to H11, H12, H22, `g` and `x` to two numbers.
//
// # Safety
// Each pointer is null or points to as many numbers and constraints; `x` may be written.
enum SaltusStatus saltus_controller_qp2(const float (*h)[3],
                                        const float (*g)[2],
                                        const struct SaltusHalfPlane *constraints,
                                        uintptr_t count,
                                        float (*x)[2]);

// Follows the lean of a pivoting wheel through an encoder's reading `lean` (rad); `pendulum` (1/s²), `period` (s), `memory` from 0 to below 1.
//
// # Safety
// `state` is null or may be read and written.
void saltus_controller_observe(struct SaltusSensed *state,
                               float lean,
                               float pendulum,
                               float period,
                               float memory);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SALTUS_CONTROLLER_FFI_H */
