//! Tables as C: a header and a source.

use saltus_controller::Axis;
use saltus_controller::c_source::{CONTROLLER as SOURCE, CONTROLLER_HEADER as HEADER};

use super::numbers::Number;
use super::tables::{Nodes, Tables};

/// Vectors of the self-test: firing angles, decisions, take-offs, programs.
const VECTORS: [usize; 4] = [20, 40, 10, 10];

impl<R: Number> Tables<R> {
    /// `saltus_controller.h` and `saltus_controller.c`, in C99 with no other dependency than
    /// `math.h`'s square root.
    pub fn c(&self) -> [String; 2] {
        let comment = comment(&self.about());
        let header = HEADER
            .replace("@HEADER@", &comment)
            .replace("@CRC@", &format!("0x{:08X}u", self.crc()));
        let rule = match self.nodes {
            Nodes::Curve(_) => CURVE,
            Nodes::Table(_) => TABLE,
        };
        let source = fill(
            SOURCE,
            [
                ("HEADER", comment),
                ("DATA", self.c_data()),
                ("RULE", rule.to_owned()),
                ("SELF_TEST", self.c_self_test()),
                ("ROUND_OFF", R::ROUND_OFF.c()),
            ],
        );
        let source = fill(&source, self.c_numbers());
        [header, source].map(|text| fill(&text, number_words::<R>()))
    }

    /// The numbers of robot, limits and rates, as the source names them.
    fn c_numbers(&self) -> impl Iterator<Item = (&'static str, String)> {
        let (robot, limits, rates) = (&self.robot, &self.limits, &self.counted);
        let chooses = limits.greatest_valve_open > limits.least_valve_open;
        let flags = [
            ("at_firing", u8::from(rates.at_firing)),
            ("newton_steps", limits.newton_steps.min(3)),
            ("chooses_valve", u8::from(chooses)),
        ];
        let numbers = [
            ("radius", robot.radius),
            ("gravity", robot.gravity),
            ("pendulum", robot.pendulum),
            ("reference_lean", rates.reference_lean),
            ("least_rate", rates.least),
            ("greatest_rate", rates.greatest),
            ("stride", robot.stride),
            ("valve_open", robot.valve_open),
            ("landing_height", robot.landing_height),
            ("period", limits.period),
            ("extra_delay", limits.extra_delay),
            ("least_valve_open", limits.least_valve_open),
            ("greatest_valve_open", limits.greatest_valve_open),
            ("effort", limits.effort),
        ];
        let flags = flags.map(|(name, flag)| (name, flag.to_string()));
        let numbers = numbers.map(|(name, x)| (name, x.c()));
        flags.into_iter().chain(numbers)
    }

    fn c_data(&self) -> String {
        let rate = "rate at the reference lean (rad/s)";
        let mut text = axis("rule_rates", &self.rates, rate);
        match &self.nodes {
            Nodes::Table(table) => {
                text += &axis("table_distances", &self.distances, "distance (m)");
                let what = "alpha_f (rad), by rate and by distance, mixed, each times the \
                    spacing; distances within rates";
                text += &nodes("rule_nodes", table, what);
            }
            Nodes::Curve(curve) => {
                let distance = self.distances.first.c();
                text += &["static const saltus_real curve_distance = ", &distance].concat();
                text += "; /* (m) */\n";
                let what = "alpha_f (rad), and its slope by rate times the spacing";
                text += &nodes("rule_nodes", curve, what);
            }
        }
        text += &cells("rule_open", &self.open);
        text += &axis("map_rates", &self.rates, rate);
        text += &axis("map_angles", &self.angles, "firing angle (rad)");
        let what = "x, y (m), vx, vy (m/s); these by rate; by angle; mixed, times the spacing; \
            then by the valve opening time (1/s)";
        text += &nodes("map_nodes", &self.map_nodes, what);
        text += &cells("map_open", &self.map_open);
        text.truncate(text.trim_end().len());
        text
    }

    fn c_self_test(&self) -> String {
        let [angles, decisions, take_offs, programs] = VECTORS;
        let tables = [
            vectors("angle", &self.firing_angles(angles)),
            vectors("decision", &self.decisions(decisions)),
            vectors("take_off", &self.take_offs(take_offs)),
            vectors("program", &Tables::<R>::programs(programs)),
        ];
        let counts = ["ANGLES", "DECISIONS", "TAKE_OFFS", "PROGRAMS"].into_iter();
        let test = fill(TEST, counts.zip(VECTORS.map(|count| count.to_string())));
        format!("{CRC}{TEST_TYPES}{}{test}", tables.join("\n"))
    }
}

/// The table of a kind of test: an array of `test_KIND`.
fn vectors(kind: &str, rows: &[String]) -> String {
    let count = rows.len();
    let rows = rows.join("},\n    {");
    format!("static const test_{kind} test_{kind}s[{count}] = {{\n    {{{rows}}},\n}};\n")
}

/// Lines at the head of a file.
pub(super) fn comment(lines: &[String]) -> String {
    let lines: Vec<String> = lines.iter().map(|line| format!(" * {line}")).collect();
    // A robot's name is the user's.
    format!("/*\n{}\n */", lines.join("\n").replace("*/", "* /"))
}

/// What the code calls numbers and their functions.
pub(super) fn number_words<R: Number>() -> [(&'static str, String); 7] {
    let words: [(&str, [&str; 2]); 7] = [
        ("REAL", ["float", "double"]),
        ("SUFFIX", ["x##f", "x"]),
        ("SQRT", ["sqrtf", "sqrt"]),
        ("ABS", ["fabsf", "fabs"]),
        ("GREAT", ["12582912.0f", "6755399441055744.0"]),
        ("GREATEST", ["FLT_MAX", "DBL_MAX"]),
        ("BITS", ["uint32_t", "uint64_t"]),
    ];
    words.map(|(name, [float, double])| {
        let word = if R::IS_FLOAT { float } else { double };
        (name, word.to_owned())
    })
}

/// A text with each `@NAME@` replaced.
pub(super) fn fill<'a>(text: &str, names: impl IntoIterator<Item = (&'a str, String)>) -> String {
    let put =
        |text: String, (name, value): (&str, String)| text.replace(&format!("@{name}@"), &value);
    names.into_iter().fold(text.to_owned(), put)
}

pub(super) fn list<R: Number>(numbers: &[R]) -> String {
    numbers.iter().map(|x| x.c()).collect::<Vec<_>>().join(", ")
}

fn axis<R: Number>(name: &str, a: &Axis<R>, what: &str) -> String {
    let numbers = list(&[a.first, a.last, a.per_unit]);
    let count = a.count;
    format!(
        "/* {what}: first, last, nodes per unit, how many */\nstatic const axis {name} = {{{numbers}, \
         {count}}};\n"
    )
}

fn nodes<R: Number, const N: usize>(name: &str, nodes: &[[R; N]], what: &str) -> String {
    let count = nodes.len();
    let row = |node: &[R; N]| format!("    {{{}}},\n", list(node));
    let rows = nodes.iter().map(row).collect::<Vec<_>>().concat();
    format!("/* {what} */\nstatic const saltus_real {name}[{count}][{N}] = {{\n{rows}}};\n")
}

fn cells(name: &str, open: &[u8]) -> String {
    let list: Vec<String> = open.iter().map(u8::to_string).collect();
    let (count, list) = (open.len(), list.join(", "));
    format!("/* which cells may be used */\nstatic const uint8_t {name}[{count}] = {{{list}}};\n\n")
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
