//! Tables as C: a header and a source.

use std::fmt::Write;

use saltus_controller::{Axis, Input, NoTakeOff, Reason, Timing};

use super::numbers::Number;
use super::tables::{Nodes, Tables};

const HEADER: &str = include_str!("../../../controller/c/saltus_controller.h");
const SOURCE: &str = include_str!("../../../controller/c/saltus_controller.c");

/// Vectors of the self-test: firing angles, decisions, take-offs, programs.
const VECTORS: [usize; 4] = [20, 40, 10, 10];

impl<R: Number> Tables<R> {
    /// `saltus_controller.h` and `saltus_controller.c`, in C99 with no other dependency than
    /// `math.h`'s square root.
    pub fn c(&self) -> [String; 2] {
        let comment = self.comment();
        let header = HEADER
            .replace("@HEADER@", &comment)
            .replace("@REAL@", R::C_TYPE)
            .replace("@CRC@", &format!("0x{:08X}u", self.crc()));
        let float = R::IS_FLOAT;
        let choose =
            |single: &'static str, double: &'static str| if float { single } else { double };
        let source = SOURCE
            .replace("@HEADER@", &comment)
            .replace("@DATA@", &self.c_data())
            .replace(
                "@RULE@",
                if matches!(self.nodes, Nodes::Curve(_)) {
                    CURVE
                } else {
                    TABLE
                },
            )
            .replace("@SELF_TEST@", &self.c_self_test())
            .replace("@SUFFIX@", choose("x##f", "x"))
            .replace("@SQRT@", choose("sqrtf", "sqrt"))
            .replace("@ABS@", choose("fabsf", "fabs"))
            .replace("@GREAT@", choose("12582912.0f", "6755399441055744.0"))
            .replace("@GREATEST@", choose("FLT_MAX", "DBL_MAX"))
            .replace("@ROUND_OFF@", &R::ROUND_OFF.c())
            .replace("@BITS@", choose("uint32_t", "uint64_t"));
        [header, source]
    }

    fn comment(&self) -> String {
        let lines: Vec<String> = self
            .about()
            .iter()
            .map(|line| format!(" * {line}"))
            .collect();
        // A robot's name is the user's.
        format!("/*\n{}\n */", lines.join("\n").replace("*/", "* /"))
    }

    fn c_data(&self) -> String {
        let mut text = String::new();
        let robot = &self.robot;
        let (limits, rates) = (&self.limits, &self.counted);
        let numbers = [
            (
                "radius",
                robot.radius,
                "foot to wheel centre, leg retracted (m)",
            ),
            ("gravity", robot.gravity, "at the axle (m/s^2)"),
            ("pendulum", robot.pendulum, "m g r/(I + m r^2) (1/s^2)"),
            (
                "reference_lean",
                rates.reference_lean,
                "where the rates of the tables count (rad)",
            ),
            ("least_rate", rates.least, "least approach rate (rad/s)"),
            (
                "greatest_rate",
                rates.greatest,
                "greatest approach rate (rad/s)",
            ),
            (
                "stride",
                robot.stride,
                "from one touch-down to the next (m)",
            ),
            ("nominal_valve_open", robot.valve_open, "(s)"),
            (
                "landing_height",
                robot.landing_height,
                "of the wheel's centre (m)",
            ),
            ("period", limits.period, "of control (s)"),
            (
                "extra_delay",
                limits.extra_delay,
                "of the valve, beyond the robot file's (s)",
            ),
            ("least_valve_open", limits.least_valve_open, "(s)"),
            ("greatest_valve_open", limits.greatest_valve_open, "(s)"),
            (
                "effort",
                limits.effort,
                "cost of a squared second of open valve (m^2/s^2)",
            ),
        ];
        for (name, value, what) in numbers {
            put(
                &mut text,
                format_args!(
                    "static const saltus_real {name} = {}; /* {what} */\n",
                    value.c()
                ),
            );
        }
        let at_firing = u8::from(rates.at_firing);
        put(
            &mut text,
            format_args!(
                "/* 1: approach rates count at the firing angle; 0: at the reference lean \
                 */\n#define AT_FIRING {at_firing}\n"
            ),
        );
        put(
            &mut text,
            format_args!("#define NEWTON_STEPS {}\n", limits.newton_steps.min(3)),
        );
        let chooses = u8::from(limits.greatest_valve_open > limits.least_valve_open);
        put(
            &mut text,
            format_args!("#define CHOOSES_VALVE {chooses}\n\n"),
        );
        axis(
            &mut text,
            "rule_rates",
            &self.rates,
            "rate at the reference lean (rad/s)",
        );
        match &self.nodes {
            Nodes::Table(table) => {
                axis(
                    &mut text,
                    "table_distances",
                    &self.distances,
                    "distance (m)",
                );
                let what = "alpha_f (rad), by rate and by distance, mixed, each times the \
                    spacing; distances within rates";
                nodes(&mut text, "rule_nodes", table, what);
            }
            Nodes::Curve(curve) => {
                let distance = self.distances.first.c();
                put(
                    &mut text,
                    format_args!(
                        "static const saltus_real curve_distance = {distance}; /* (m) */\n"
                    ),
                );
                nodes(
                    &mut text,
                    "rule_nodes",
                    curve,
                    "alpha_f (rad), and its slope by rate times the spacing",
                );
            }
        }
        cells(&mut text, "rule_open", &self.open);
        axis(
            &mut text,
            "map_rates",
            &self.rates,
            "rate at the reference lean (rad/s)",
        );
        axis(&mut text, "map_angles", &self.angles, "firing angle (rad)");
        let what = "x, y (m), vx, vy (m/s); these by rate; by angle; mixed, times the spacing; \
            then by the valve opening time (1/s)";
        nodes(&mut text, "map_nodes", &self.map_nodes, what);
        cells(&mut text, "map_open", &self.map_open);
        text.truncate(text.trim_end().len());
        text
    }

    fn c_self_test(&self) -> String {
        let mut text = CRC.to_owned();
        text.push_str(TEST_TYPES);
        let [angles, decisions, take_offs, programs] = VECTORS;
        put(
            &mut text,
            format_args!("static const test_angle test_angles[{angles}] = {{\n"),
        );
        for v in self.firing_angles(angles) {
            let (code, angle) = match v.answer {
                Ok(angle) => ("SALTUS_OK", angle),
                Err(reason) => (status(reason), R::ZERO),
            };
            put(
                &mut text,
                format_args!("    {{{}, {code}, {}}},\n", list(&v.given), angle.c()),
            );
        }
        put(
            &mut text,
            format_args!("}};\n\nstatic const test_decision test_decisions[{decisions}] = {{\n"),
        );
        for v in self.decisions(decisions) {
            let (sensed, task) = (&v.sensed, &v.task);
            let obstacle = task
                .obstacle
                .map(|o| list(&[o.front, o.back, o.height, o.clearance]));
            let (over, obstacle) = (
                u8::from(obstacle.is_some()),
                obstacle.unwrap_or_else(|| list(&[R::ZERO; 4])),
            );
            let answer = match v.answer {
                Ok(d) => {
                    let (timing, time) = timing(d.timing);
                    let numbers = list(&[d.approach_rate, d.firing_angle, d.valve_open, time]);
                    format!(
                        "SALTUS_OK, {{{numbers}, {timing}, {}}}",
                        u8::from(d.settled)
                    )
                }
                Err(reason) => format!(
                    "{}, {{{}, SALTUS_WAIT, 0}}",
                    status(reason),
                    list(&[R::ZERO; 4])
                ),
            };
            let (sensed, task) = (
                list(&[sensed.lean, sensed.rate]),
                list(&[task.distance, task.landing_height]),
            );
            put(
                &mut text,
                format_args!("    {{{{{sensed}}}, {task}, {over}, {{{obstacle}}}, {answer}}},\n"),
            );
        }
        put(
            &mut text,
            format_args!("}};\n\nstatic const test_take_off test_take_offs[{take_offs}] = {{\n"),
        );
        for v in self.take_offs(take_offs) {
            let a = &v.approach;
            let given = list(&[a.distance, a.height, a.length, a.speed, a.clearance]);
            let answer = match v.answer {
                Ok(t) => {
                    let numbers = list(&[t.approach_rate, t.firing_angle, t.distance, t.clearance]);
                    format!(
                        "SALTUS_OK, SALTUS_NO_INPUT, {{{}, {numbers}}}",
                        t.touch_down
                    )
                }
                Err(NoTakeOff {
                    reason,
                    input: which,
                }) => {
                    format!(
                        "{}, {}, {{0, {}}}",
                        status(reason),
                        input(which),
                        list(&[R::ZERO; 4])
                    )
                }
            };
            put(&mut text, format_args!("    {{{{{given}}}, {answer}}},\n"));
        }
        put(
            &mut text,
            format_args!("}};\n\nstatic const test_program test_programs[{programs}] = {{\n"),
        );
        for v in Tables::<R>::programs(programs) {
            let rows: Vec<String> = v
                .constraints
                .iter()
                .map(|c| format!("{{{{{}}}, {}}}", list(&c.normal), c.bound.c()))
                .collect();
            let (code, x) = match v.answer {
                Ok(x) => ("SALTUS_OK", x),
                Err(reason) => (status(reason), [R::ZERO; 2]),
            };
            put(
                &mut text,
                format_args!(
                    "    {{{{{}}}, {{{}}}, {{{}}}, {code}, {{{}}}}},\n",
                    list(&v.h),
                    list(&v.g),
                    rows.join(", "),
                    list(&x)
                ),
            );
        }
        text.push_str("};\n");
        text.push_str(
            &TEST
                .replace("@ANGLES@", &angles.to_string())
                .replace("@DECISIONS@", &decisions.to_string())
                .replace("@TAKE_OFFS@", &take_offs.to_string())
                .replace("@PROGRAMS@", &programs.to_string()),
        );
        text
    }
}

fn put(text: &mut String, what: std::fmt::Arguments<'_>) {
    // Writing to a string does not fail.
    let _ = text.write_fmt(what);
}

fn list<R: Number>(numbers: &[R]) -> String {
    numbers.iter().map(|x| x.c()).collect::<Vec<_>>().join(", ")
}

fn axis<R: Number>(text: &mut String, name: &str, a: &Axis<R>, what: &str) {
    let numbers = list(&[a.first, a.last, a.per_unit]);
    put(
        text,
        format_args!(
            "/* {what}: first, last, nodes per unit, how many */\nstatic const axis {name} = \
             {{{numbers}, {}}};\n",
            a.count
        ),
    );
}

fn nodes<R: Number, const N: usize>(text: &mut String, name: &str, nodes: &[[R; N]], what: &str) {
    put(
        text,
        format_args!(
            "/* {what} */\nstatic const saltus_real {name}[{}][{N}] = {{\n",
            nodes.len()
        ),
    );
    for node in nodes {
        put(text, format_args!("    {{{}}},\n", list(node)));
    }
    text.push_str("};\n");
}

fn cells(text: &mut String, name: &str, open: &[u8]) {
    let list: Vec<String> = open.iter().map(u8::to_string).collect();
    put(
        text,
        format_args!(
            "/* which cells may be used */\nstatic const uint8_t {name}[{}] = {{{}}};\n\n",
            open.len(),
            list.join(", ")
        ),
    );
}

fn status(reason: Reason) -> &'static str {
    match reason {
        Reason::OutOfTable => "SALTUS_OUT_OF_TABLE",
        Reason::Infeasible => "SALTUS_INFEASIBLE",
        Reason::SensorInvalid => "SALTUS_SENSOR_INVALID",
        Reason::AskLater => "SALTUS_ASK_LATER",
    }
}

fn input(input: Option<Input>) -> &'static str {
    match input {
        None => "SALTUS_NO_INPUT",
        Some(Input::Distance) => "SALTUS_INPUT_DISTANCE",
        Some(Input::Height) => "SALTUS_INPUT_HEIGHT",
        Some(Input::Length) => "SALTUS_INPUT_LENGTH",
        Some(Input::Speed) => "SALTUS_INPUT_SPEED",
        Some(Input::Clearance) => "SALTUS_INPUT_CLEARANCE",
    }
}

fn timing<R: Number>(timing: Timing<R>) -> (&'static str, R) {
    match timing {
        Timing::Wait(time) => ("SALTUS_WAIT", time),
        Timing::Fire(time) => ("SALTUS_FIRE", time),
        Timing::Late(time) => ("SALTUS_LATE", time),
    }
}

const CURVE: &str = "\
static enum saltus_status check_distance(saltus_real distance) {
    if (!is_finite(distance)) return SALTUS_SENSOR_INVALID;
    return distance == curve_distance ? SALTUS_OK : SALTUS_OUT_OF_TABLE;
}

static enum saltus_status rule(saltus_real rate, saltus_real distance, saltus_real *angle) {
    spot i;
    enum saltus_status status = locate(&rule_rates, rate, &i);
    if (status) return status;
    status = check_distance(distance);
    if (status) return status;
    if (!rule_open[i.cell]) return SALTUS_INFEASIBLE;
    const saltus_real *a = rule_nodes[i.cell], *b = rule_nodes[i.cell + 1];
    saltus_real u[3];
    hermite(i.part, u);
    *angle = cubic(u, a[0], a[1], b[0], b[1]);
    return SALTUS_OK;
}

/* The angles at both ends of a cell of rates. */
static enum saltus_status rule_ends(uint32_t cell, saltus_real distance, saltus_real *low, saltus_real *high) {
    enum saltus_status status = check_distance(distance);
    if (status) return status;
    if (!rule_open[cell]) return SALTUS_INFEASIBLE;
    *low = rule_nodes[cell][0];
    *high = rule_nodes[cell + 1][0];
    return SALTUS_OK;
}";

const TABLE: &str = "\
static enum saltus_status rule(saltus_real rate, saltus_real distance, saltus_real *angle) {
    spot i, j;
    enum saltus_status status = locate(&rule_rates, rate, &i);
    if (status) return status;
    status = locate(&table_distances, distance, &j);
    if (status) return status;
    if (!rule_open[i.cell * (table_distances.count - 1) + j.cell]) return SALTUS_INFEASIBLE;
    uint32_t first = i.cell * table_distances.count + j.cell, second = first + table_distances.count;
    const saltus_real *a = rule_nodes[first], *b = rule_nodes[first + 1];
    const saltus_real *c = rule_nodes[second], *d = rule_nodes[second + 1];
    saltus_real u[3], v[3];
    hermite(i.part, u);
    hermite(j.part, v);
    saltus_real low = cubic(v, a[0], a[2], b[0], b[2]), low_slope = cubic(v, a[1], a[3], b[1], b[3]);
    saltus_real high = cubic(v, c[0], c[2], d[0], d[2]), high_slope = cubic(v, c[1], c[3], d[1], d[3]);
    *angle = cubic(u, low, low_slope, high, high_slope);
    return SALTUS_OK;
}

/* The angles for a distance at both ends of a cell of rates. */
static enum saltus_status rule_ends(uint32_t cell, saltus_real distance, saltus_real *low, saltus_real *high) {
    spot j;
    enum saltus_status status = locate(&table_distances, distance, &j);
    if (status) return status;
    if (!rule_open[cell * (table_distances.count - 1) + j.cell]) return SALTUS_INFEASIBLE;
    uint32_t first = cell * table_distances.count + j.cell, second = first + table_distances.count;
    const saltus_real *a = rule_nodes[first], *b = rule_nodes[first + 1];
    const saltus_real *c = rule_nodes[second], *d = rule_nodes[second + 1];
    saltus_real v[3];
    hermite(j.part, v);
    *low = cubic(v, a[0], a[2], b[0], b[2]);
    *high = cubic(v, c[0], c[2], d[0], d[2]);
    return SALTUS_OK;
}";

const CRC: &str = "\
static uint32_t crc_of_cells(uint32_t crc, const uint8_t *cells, size_t count) {
    for (size_t k = 0; k < count; k++) {
        crc ^= cells[k];
        for (int bit = 0; bit < 8; bit++) crc = (crc >> 1) ^ (0xEDB88320u & (0u - (crc & 1u)));
    }
    return crc;
}

uint32_t saltus_crc(void) {
    uint32_t crc = 0xFFFFFFFFu;
    crc = crc_of(crc, &rule_nodes[0][0], sizeof rule_nodes / sizeof(saltus_real));
    crc = crc_of(crc, &map_nodes[0][0], sizeof map_nodes / sizeof(saltus_real));
    crc = crc_of_cells(crc, rule_open, sizeof rule_open);
    crc = crc_of_cells(crc, map_open, sizeof map_open);
    return crc ^ 0xFFFFFFFFu;
}
";

const TEST_TYPES: &str = "
#ifndef SALTUS_NO_SELF_TEST
typedef struct { saltus_real rate, distance; enum saltus_status status; saltus_real angle; } test_angle;
typedef struct {
    saltus_sensed sensed;
    saltus_real distance, height;
    int over;
    saltus_obstacle obstacle;
    enum saltus_status status;
    saltus_decision answer;
} test_decision;
typedef struct {
    saltus_approach approach;
    enum saltus_status status;
    enum saltus_input input;
    saltus_take_off answer;
} test_take_off;
typedef struct {
    saltus_real h[3], g[2];
    saltus_half_plane constraints[4];
    enum saltus_status status;
    saltus_real x[2];
} test_program;

";

const TEST: &str = "
int saltus_self_test(void) {
    int number = 1;
    if (saltus_crc() != SALTUS_CRC) return number;
    for (int k = 0; k < @ANGLES@; k++) {
        const test_angle *t = &test_angles[k];
        saltus_real angle;
        number++;
        if (saltus_firing_angle(t->rate, t->distance, landing_height, &angle) != t->status) return number;
        if (t->status == SALTUS_OK && angle != t->angle) return number;
    }
    for (int k = 0; k < @DECISIONS@; k++) {
        const test_decision *t = &test_decisions[k];
        saltus_task task = {t->distance, t->height, t->over ? &t->obstacle : NULL, NULL};
        saltus_decision d;
        number++;
        if (saltus_decide(&t->sensed, &task, &d) != t->status) return number;
        if (t->status != SALTUS_OK) continue;
        if (d.approach_rate != t->answer.approach_rate || d.firing_angle != t->answer.firing_angle) return number;
        if (d.valve_open != t->answer.valve_open || d.time != t->answer.time || d.timing != t->answer.timing) return number;
        if (d.settled != t->answer.settled) return number;
    }
    for (int k = 0; k < @TAKE_OFFS@; k++) {
        const test_take_off *t = &test_take_offs[k];
        saltus_take_off a;
        number++;
        enum saltus_input input;
        if (saltus_choose_take_off(&t->approach, &a, &input) != t->status || input != t->input) return number;
        if (t->status != SALTUS_OK) continue;
        if (a.touch_down != t->answer.touch_down || a.approach_rate != t->answer.approach_rate) return number;
        if (a.firing_angle != t->answer.firing_angle || a.distance != t->answer.distance) return number;
        if (a.clearance != t->answer.clearance) return number;
    }
    for (int k = 0; k < @PROGRAMS@; k++) {
        const test_program *t = &test_programs[k];
        saltus_real x[2];
        number++;
        if (saltus_qp2(t->h, t->g, t->constraints, 4, x) != t->status) return number;
        if (t->status == SALTUS_OK && (x[0] != t->x[0] || x[1] != t->x[1])) return number;
    }
    return 0;
}
#endif";
