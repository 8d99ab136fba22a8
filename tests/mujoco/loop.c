/* The inner loop of a running robot in MuJoCo: the gas of its legs beside mj_step.
 *
 * run.py builds this file twice: as a library that it calls once a millisecond, and with -DBENCH as a program that measures how
 * long a step takes. The equations of the gas are those of jump.py (docs/model.md, "Pneumatic drive"), and run.py compares both.
 * SI units and radians; pressures are absolute. Nothing of Saltus is called.
 */
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <mujoco/mujoco.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { LEGS = 64 };

/* What all legs share. */
typedef struct {
    double kappa, exponent, heat; /* heat ratio, exponent of the chamber, R T (J/kg) */
    double root;                  /* of the temperature (K^1/2) */
    double ambient, supply;       /* Pa */
    double area, dead_volume;     /* of the piston (m2), of the chamber with the leg retracted (m3) */
    double orifice, leak;         /* effective areas (m2) */
    double choked, subsonic;      /* the constants C_1 and C_2 of the orifice */
    double critical;              /* ratio of pressures */
    double preload;               /* constant part of the return spring that the model does not have (N) */
    double substep;               /* greatest one of the gas (s) */
} Gas;

/* One leg: the valve is energised from `opens` to `closes` (s). */
typedef struct {
    double pressure, opens, closes;
    double drawn; /* from the supply so far (kg) */
} Leg;

/* Coordinates and geometries by number. */
typedef struct {
    int legs;
    int qpos[LEGS], dof[LEGS], motor[LEGS];
} Layout;

/* Base of the boom; a robot without one has its base infinitely far away. */
static int has_boom;
static double base[3];
/* Part of a foot's depth in the ground by which its place of contact is above its lowest point; MuJoCo's own is half. */
static double above = 0.5;

/* Mass flow (kg/s) through `area` from the pressure `up` to `down`; negative if `down` is greater. */
static double flow(const Gas *g, double up, double down, double area) {
    if (down > up) return -flow(g, down, up, area);
    double gain = up * area / g->root, ratio = down / up;
    if (ratio <= g->critical) return gain * g->choked;
    double e = exp((g->kappa - 1) / g->kappa * log(ratio)); /* so that ratio^(1/kappa) = ratio / e */
    return gain * g->subsonic * ratio / e * sqrt(e < 1 ? 1 - e : 0);
}

/* dP/dt (Pa/s), and the mass flow through the valve (kg/s). */
static double pressure_rate(const Gas *g, double p, double d, double speed, int energised, double *valve) {
    *valve = flow(g, energised ? g->supply : g->ambient, p, g->orifice);
    double in = *valve - (g->leak > 0 ? flow(g, p, g->ambient, g->leak) : 0);
    return g->exponent * (g->heat * in - p * g->area * speed) / (g->dead_volume + g->area * d);
}

/* Gas of one leg from `start` to `end` with the valve in one position; the extension is `d` at the start and changes evenly. */
static void gas_phase(const Gas *g, Leg *leg, double start, double end, double d, double speed, int energised) {
    if (end <= start) return;
    int count = (int)ceil((end - start) / g->substep - 1e-9);
    double h = (end - start) / count, m1, m2, m3, m4;
    for (int i = 0; i < count; i++, d += h * speed) {
        double p = leg->pressure, middle = d + 0.5 * h * speed;
        double a = pressure_rate(g, p, d, speed, energised, &m1);
        double b = pressure_rate(g, p + 0.5 * h * a, middle, speed, energised, &m2);
        double c = pressure_rate(g, p + 0.5 * h * b, middle, speed, energised, &m3);
        double e = pressure_rate(g, p + h * c, d + h * speed, speed, energised, &m4);
        leg->pressure = p + h * (a + 2 * b + 2 * c + e) / 6;
        if (energised) leg->drawn += h * (m1 + 2 * m2 + 2 * m3 + m4) / 6;
    }
}

/* Gas of one leg from `start` to `end`, past the opening and the closing of its valve on the way. */
void gas(const Gas *g, Leg *leg, double start, double end, double d, double speed) {
    double opens = fmin(fmax(leg->opens, start), end), closes = fmin(fmax(leg->closes, opens), end);
    gas_phase(g, leg, start, opens, d, speed, 0);
    gas_phase(g, leg, opens, closes, d + speed * (opens - start), speed, 1);
    gas_phase(g, leg, closes, end, d + speed * (closes - start), speed, 0);
}

/* A sphere on the ground. MuJoCo's own function has the first tangent along y; here it is along the boom, across the travel. */
static int sphere_on_plane(const mjModel *m, mjData *d, mjPreContact *con, int plane, int sphere, mjtNum margin) {
    const mjtNum *at = d->geom_xpos + 3 * sphere, *from = d->geom_xpos + 3 * plane, *frame = d->geom_xmat + 9 * plane;
    double radius = m->geom_size[3 * sphere], dist = -radius;
    for (int i = 0; i < 3; i++) dist += (at[i] - from[i]) * frame[3 * i + 2];
    if (dist > margin) return 0;
    con->dist = dist;
    for (int i = 0; i < 3; i++) {
        con->normal[i] = frame[3 * i + 2];
        con->pos[i] = at[i] - con->normal[i] * (radius + above * dist);
        con->tangent[i] = has_boom ? at[i] - base[i] : i == 1;
    }
    con->tangent[2] = 0;
    mju_normalize3(con->tangent);
    return 1;
}

/* Number of a leg's joint or motor; -1 if there is none. */
static int numbered(const mjModel *m, int type, int k) {
    char name[16];
    snprintf(name, sizeof name, "leg_%d", k);
    return mj_name2id(m, type, name);
}

/* Makes the legs of an exported model free sliders and sets the step (s) and the damping ratio of contacts and end stops. */
void prepare(mjModel *m, Layout *l, double step, double ratio, double tolerance) {
    m->opt.timestep = step;
    m->opt.tolerance = tolerance;
    for (int i = 0; i < m->npair; i++) m->pair_solref[mjNREF * i + 1] = ratio;
    for (int i = 0; i < m->njnt; i++) m->jnt_solref[mjNREF * i + 1] = ratio;
    for (int i = 0; i < m->neq; i++) m->eq_active0[i] = 0;
    for (l->legs = 0; l->legs < LEGS && numbered(m, mjOBJ_JOINT, l->legs) >= 0; l->legs++) {
        int joint = numbered(m, mjOBJ_JOINT, l->legs);
        l->qpos[l->legs] = m->jnt_qposadr[joint];
        l->dof[l->legs] = m->jnt_dofadr[joint];
        l->motor[l->legs] = numbered(m, mjOBJ_ACTUATOR, l->legs);
    }
    int boom = mj_name2id(m, mjOBJ_BODY, "boom");
    has_boom = boom >= 0;
    if (has_boom) memcpy(base, m->body_pos + 3 * boom, sizeof base);
    mjCOLLISIONFUNC[mjGEOM_PLANE][mjGEOM_SPHERE] = sphere_on_plane;
}

/* For a robot in space: its feet touch the ground at `part` of their depth above their lowest points. */
void touch_at(double part) {
    above = part;
    mjCOLLISIONFUNC[mjGEOM_PLANE][mjGEOM_SPHERE] = sphere_on_plane;
}

/* The force of each leg in the middle of the coming step, from where the leg is going. */
static void set_forces(const mjModel *m, mjData *d, const Layout *l, const Gas *g, const Leg *legs) {
    double h = m->opt.timestep;
    for (int k = 0; k < l->legs; k++) {
        Leg middle = legs[k];
        gas(g, &middle, d->time, d->time + 0.5 * h, d->qpos[l->qpos[k]], d->qvel[l->dof[k]]);
        d->ctrl[l->motor[k]] = (middle.pressure - g->ambient) * g->area - g->preload;
    }
}

/* The gas of each leg over the step that ends now; `before` are the extensions at its start. */
static void follow(const mjModel *m, const mjData *d, const Layout *l, const Gas *g, Leg *legs, const double *before) {
    double h = m->opt.timestep;
    for (int k = 0; k < l->legs; k++)
        gas(g, legs + k, d->time - h, d->time, before[k], (d->qpos[l->qpos[k]] - before[k]) / h);
}

/* Makes `steps` steps. */
void advance(const mjModel *m, mjData *d, const Layout *l, const Gas *g, Leg *legs, int steps) {
    double before[LEGS];
    for (int n = 0; n < steps; n++) {
        set_forces(m, d, l, g, legs);
        for (int k = 0; k < l->legs; k++) before[k] = d->qpos[l->qpos[k]];
        mj_step(m, d);
        follow(m, d, l, g, legs, before);
    }
}

#ifdef BENCH

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

/* The fixed gait, once each millisecond: the leg in the zone [0, 2 pi/n) fires when its lean has reached alpha_f. */
static void control(const mjData *d, const Layout *l, Leg *legs, double lean, double alpha_f, double open, double delay) {
    static long entry = -1000;
    static int fired;
    const double two_pi = 6.283185307179586, count = two_pi / 800, zone = two_pi / l->legs;
    double read = count * floor(lean / count + 0.5);
    long k = (long)floor(read / zone + 1e-9);
    if (k != entry) entry = k, fired = 0;
    if (fired || read - k * zone < alpha_f) return;
    Leg *leg = legs + ((k % l->legs) + l->legs) % l->legs;
    leg->opens = d->time + delay;
    leg->closes = leg->opens + open;
    fired = 1;
}

int main(int argc, char **argv) {
    enum { FIRST = 8 };
    if (argc != FIRST + (int)(sizeof(Gas) / sizeof(double))) {
        fprintf(stderr, "use: %s MODEL.xml STEP SECONDS TOLERANCE DELAY THETA LEAN GAS...\n", argv[0]);
        return 2;
    }
    char error[1000];
    mjModel *m = mj_loadXML(argv[1], NULL, error, sizeof error);
    if (!m) return fprintf(stderr, "%s\n", error), 2;
    double step = atof(argv[2]), seconds = atof(argv[3]), delay = atof(argv[5]);
    Gas g;
    for (size_t i = 0; i < sizeof g / sizeof(double); i++) ((double *)&g)[i] = atof(argv[FIRST + i]);
    Layout l;
    prepare(m, &l, step, 3, atof(argv[4]));
    m->opt.disableflags |= mjDSBL_SENSOR;
    mjData *d = mj_makeData(m);
    int wheel = m->jnt_dofadr[mj_name2id(m, mjOBJ_JOINT, "wheel")];
    int lean = m->jnt_qposadr[mj_name2id(m, mjOBJ_JOINT, "wheel")];
    d->qpos[1] = atof(argv[6]);
    d->qpos[lean] = atof(argv[7]);
    Leg legs[LEGS] = {0};
    for (int k = 0; k < l.legs; k++) legs[k] = (Leg){g.ambient, 1e9, 1e9, 0};
    int every = (int)(1e-3 / step + 0.5);
    long steps = lround(seconds / step), contacts = 0;
    double before[LEGS], in_gas = 0, begin = now();
    for (long n = 0; n < steps; n++) {
        if (n % every == 0) control(d, &l, legs, d->qpos[lean], 0.1, 0.04, delay);
        d->qfrc_applied[wheel] = d->time >= 0.5 && d->time < 0.7 ? 5 : 0;
        double a = now();
        set_forces(m, d, &l, &g, legs);
        for (int k = 0; k < l.legs; k++) before[k] = d->qpos[l.qpos[k]];
        double b = now();
        mj_step(m, d);
        double c = now();
        follow(m, d, &l, &g, legs, before);
        in_gas += b - a + now() - c;
        contacts += d->ncon;
    }
    double spent = now() - begin;
    printf("%.17g %.17g %.17g %.17g\n", spent / steps, in_gas / steps, d->qpos[0] / d->time, (double)contacts / steps);
    mj_deleteData(d);
    mj_deleteModel(m);
    return 0;
}

#endif
