/*
 * The drill of balls: robots that turn, tumble, stand and fall, with any feet, planes and gains, and a hash of every bit of what they know and decide.
 * The study `ball_drill` does the same in Rust.
 */
#include <string.h>

#include "counted.h"
#include "saltus_ball.h"

#ifndef CYCLES
#define CYCLES 1000000
#endif
/* Cycles of a run. */
#define RUN 1000
#define LEGS 12
#define STATIONS 6

#define N(x) ((saltus_real)(x))

static uint32_t state = 1;
/* 0, as nobody but the program knows. */
static volatile saltus_real nothing;

static uint32_t word(void) {
    state = state * 2891336453u + 12345u;
    return state >> 8;
}

/* From -most to most. */
static int32_t up_to(int32_t most) { return (int32_t)(word() % (uint32_t)(2 * most + 1)) - most; }
static int one_in(uint32_t n) { return word() % n == 0; }
/* From low to high, in steps of the difference over 2^24. */
static saltus_real between(saltus_real low, saltus_real high) { return low + (high - low) * ((saltus_real)word() / N(16777216)); }

static uint32_t hash = 2166136261u;

static void mix_word(uint32_t x) {
    for (int k = 0; k < 4; k++) hash = (hash ^ ((x >> (8 * k)) & 0xFFu)) * 16777619u;
}
/* What is not a number has many bits; here it is one word. */
static void mix_real(saltus_real x) {
    if (x != x) {
        mix_word(0x7FC00000u);
        return;
    }
    uint32_t words[sizeof x / 4];
    memcpy(words, &x, sizeof x);
    for (size_t k = 0; k < sizeof x / 4; k++) mix_word(words[k]);
}
static void mix_reals(const saltus_real *x, int count) {
    for (int k = 0; k < count; k++) mix_real(x[k]);
}

static saltus_real directions[LEGS][3];
static saltus_senses senses;
static saltus_station stations[STATIONS];
static saltus_plane plane;
static saltus_balance balance;

static void vector(saltus_real v[3]) {
    for (int k = 0; k < 3; k++) v[k] = between(N(-1.0), N(1.0));
}
static void pair(saltus_real p[2], saltus_real low, saltus_real high) {
    p[0] = between(low, high);
    p[1] = between(low, high);
}

static void draw_senses(void) {
    for (int k = 0; k < LEGS; k++) vector(directions[k]);
    saltus_scales scales = {N(0.00030521), N(0.00079897), N(0.00059856), N(0.014964), 32111};
    saltus_filter filter = {N(0.001), N(9.80665), {N(0.0), N(0.0), N(0.0)}, N(40.0), N(0.1), N(0.0), N(0.0)};
    for (int k = 0; k < 3; k++) filter.bias[k] = between(N(-0.01), N(0.01));
    filter.settles = between(N(0.0), N(0.05));
    filter.returns = between(N(0.0), N(0.3));
    saltus_feet feet = {(const saltus_real(*)[3])directions, LEGS, N(0.233), N(0.007)};
    senses.scales = scales;
    senses.filter = filter;
    senses.feet = feet;
}

static void draw_plane(void) {
    vector(plane.axis);
    vector(plane.first);
    vector(plane.ahead);
    saltus_real angle = N(0.0);
    for (int k = 0; k < STATIONS; k++) {
        stations[k].legs[0] = word() % LEGS;
        stations[k].legs[1] = one_in(2) ? stations[k].legs[0] : word() % 70;
        stations[k].angle = angle;
        angle = angle + between(N(0.1), N(1.2));
    }
    plane.stations = stations;
    plane.count = word() % (STATIONS + 1);
}

static void draw_balance(void) {
    balance.period = N(0.001);
    balance.zone = between(N(-0.5), N(0.2));
    pair(balance.angles, N(-0.2), N(0.4));
    pair(balance.opens, N(0.0), N(0.02));
    pair(balance.by_rate, N(-0.005), N(0.005));
    balance.rate = between(N(0.0), N(8.0));
    pair(balance.first, N(0.0), N(0.03));
    balance.slow = between(N(0.0), N(2.0));
    balance.stall = between(N(0.0), N(0.4));
    balance.lead = N(0.01);
    balance.least = N(0.0005);
    saltus_steer *s = &balance.steer;
    s->roll = between(N(-0.01), N(0.01));
    s->roll_rate = between(N(-0.01), N(0.01));
    s->heading = between(N(-0.01), N(0.01));
    s->heading_rate = between(N(-0.01), N(0.01));
    s->aside = between(N(-0.01), N(0.01));
    s->aside_rate = between(N(-0.01), N(0.01));
    s->sum = between(N(-0.01), N(0.01));
    s->most = between(N(0.0), N(0.01));
    s->from = between(N(-0.2), N(0.5));
    s->rest = between(N(0.0), N(0.03));
}

/* A path, and the planes of a dodecahedron, each forwards and backwards: up to ten of them are upright at a time. */
#define POINTS 4
#define PLANES 30
#define A N(0.5)
#define B N(0.8090169943749475)
#define C N(0.30901699437494745)
static const saltus_real axes[PLANES / 2][3] = {
    {N(1.0), N(0.0), N(0.0)}, {N(0.0), N(1.0), N(0.0)}, {N(0.0), N(0.0), N(1.0)},
    {A, B, C}, {A, B, -C}, {A, -B, C}, {A, -B, -C},
    {B, C, A}, {B, -C, A}, {-B, C, A}, {-B, -C, A},
    {C, A, B}, {-C, A, B}, {C, A, -B}, {-C, A, -B},
};
static saltus_real path[POINTS][2];
static saltus_plane planes[PLANES];
static saltus_lead lead;

static void draw_lead(void) {
    for (int k = 0; k < POINTS; k++) {
        path[k][0] = between(N(-5.0), N(5.0));
        path[k][1] = between(N(-5.0), N(5.0));
    }
    for (int k = 0; k < PLANES; k++) {
        planes[k] = plane;
        for (int i = 0; i < 3; i++) planes[k].axis[i] = k % 2 ? -axes[k / 2][i] : axes[k / 2][i];
    }
    lead.balance = &balance;
    lead.ahead = between(N(0.0), N(3.0));
    lead.slew = between(N(0.0), N(1.0));
    lead.tips = between(N(0.1), N(1.5));
    lead.astray = between(N(0.0), N(20.0));
    lead.turn = between(N(0.1), N(3.0));
    lead.near = between(N(0.0), N(1.0));
    lead.still = between(N(0.0), N(20.0));
    lead.rests = between(N(0.0), N(0.05));
    lead.patience = between(N(0.0), N(0.3));
}

/* What the sensors say: rates that go after others, shocks, and feet that come and go. */
static int32_t rates[3], wanted[3];

static void tumble(saltus_inertial *r) {
    int32_t end = 32767;
    if (one_in(300)) {
        for (int k = 0; k < 3; k++) wanted[k] = one_in(4) ? 0 : up_to(40000);
    }
    int32_t shock = one_in(100) ? 32767 : 800;
    for (int k = 0; k < 3; k++) {
        rates[k] += (wanted[k] - rates[k]) / 64;
        int32_t fine = rates[k] + up_to(90);
        r->fine_gyro[k] = fine > end ? end : fine < -end ? -end : fine;
        r->coarse_gyro[k] = rates[k] * 3 / 8 + up_to(40);
        r->fine_accelerometer[k] = up_to(16384);
        r->coarse_accelerometer[k] = up_to(shock);
    }
    if (one_in(60)) {
        uint64_t low = word(), high = word();
        r->touching = one_in(4) ? ~(uint64_t)0 : one_in(3) ? 0 : (low & word()) | high << 40;
    }
}

/* A number of the sight that is none, or has no bound. */
static saltus_real odd(void) {
    saltus_real one = nothing + N(1.0);
    uint32_t which = word() % 4;
    return which < 2 ? nothing / nothing : which == 2 ? one / nothing : -one / nothing;
}

static void see(saltus_sight *sight, const saltus_estimate *e, saltus_real course) {
    sight->attitude = e->attitude;
    for (int k = 0; k < 3; k++) sight->spin[k] = e->spin[k];
    sight->aside = e->place[1];
    sight->aside_rate = e->velocity[1];
    sight->course = course;
    if (one_in(100)) {
        switch (word() % 6) {
        case 0: sight->attitude.x = odd(); break;
        case 1: sight->attitude.w = sight->attitude.x = sight->attitude.y = sight->attitude.z = nothing; break;
        case 2: sight->spin[1] = odd(); break;
        case 3: sight->aside = odd(); break;
        case 4: sight->aside_rate = odd(); break;
        default: sight->course = odd();
        }
    }
}

static void mix(const saltus_estimate *e, const saltus_lying *l, const saltus_firing firings[2]) {
    const saltus_real known[10] = {e->attitude.w, e->attitude.x, e->attitude.y, e->attitude.z, l->lean, l->rate, l->roll, l->roll_rate,
        l->heading, l->heading_rate};
    mix_reals(known, 10);
    mix_reals(e->spin, 3);
    mix_reals(e->velocity, 3);
    mix_reals(e->place, 3);
    for (int side = 0; side < 2; side++) {
        mix_word((uint32_t)firings[side].leg);
        mix_real(firings[side].open);
    }
}

/* How a ball lies, by what its sensors say at rest or while it is moved; any attitude where it cannot tell. */
static uint32_t knew;

static saltus_rotation lie(void) {
    saltus_at_rest rest = {{0, 0, 0}, 0, 0, 0};
    saltus_inertial r;
    memset(&r, 0, sizeof r);
    int32_t up[3], noise = one_in(4) ? 8000 : 300, far = one_in(9) ? 99 : 200;
    for (int k = 0; k < 3; k++) up[k] = up_to(16000);
    /* Of a third of them the length is that of gravity for sure. */
    if (one_in(3)) {
        up[0] /= 8;
        up[1] /= 8;
        up[2] = up[2] < 0 ? -16000 : 16000;
    }
    for (int32_t cycles = 0; cycles < far; cycles++) {
        for (int k = 0; k < 3; k++) {
            r.fine_accelerometer[k] = up[k] + up_to(noise);
            r.fine_gyro[k] = up_to(one_in(4000) ? 3000 : 300);
        }
        saltus_at_rest_take(&rest, &senses.scales, &r);
    }
    saltus_rotation attitude = {N(0.5), N(0.5), N(-0.5), N(0.5)};
    enum saltus_rest_status status = saltus_attitude(&rest, &senses, &attitude);
    mix_word((uint32_t)status);
    knew += status == SALTUS_REST_OK;
    return attitude;
}

static void cycle(saltus_estimator *e, saltus_balancer *b, saltus_pilot *p, const saltus_inertial *r, const saltus_sight *sight, saltus_lying *l,
    saltus_firing f[2]) {
    saltus_estimator_take(e, r);
    if (p) {
        const saltus_estimate *now = &e->estimate;
        saltus_view view = {sight->attitude, {sight->spin[0], sight->spin[1], sight->spin[2]}, {sight->aside, now->place[1]},
            {sight->aside_rate, now->velocity[1]}, sight->touching};
        saltus_pilot_step(p, &view, f);
    } else {
        saltus_balancer_step(b, sight, l, f);
    }
    for (int side = 0; side < 2; side++) saltus_estimator_fired(e, f[side].leg);
}

/* Bytes of the stack that a cycle takes; what is not painted, 256 of them, counts as taken. */
__attribute__((noinline)) static uint32_t stack_of(const saltus_estimator *e, const saltus_balancer *b, const saltus_pilot *p, const saltus_inertial *r,
    const saltus_sight *sight) {
    static saltus_pilot pilot;
    static saltus_lying lying;
    static saltus_firing firings[2];
    static saltus_estimator estimator;
    static saltus_balancer balancer;
    estimator = *e;
    balancer = *b;
    if (p) pilot = *p;
    uint32_t top;
    paint();
    cycle(&estimator, &balancer, p ? &pilot : NULL, r, sight, &lying, firings);
    return deepest(&top);
}

int main(void) {
    start_clock();
    uint32_t from = now(), fired = 0, starts = 0, most = 0;
    overhead = instructions(from, now());
    begin();
    for (uint32_t run = 0; run < CYCLES / RUN; run++) {
        static saltus_estimator estimator;
        static saltus_balancer balancer;
        saltus_inertial readings;
        saltus_sight sight;
        saltus_lying lying;
        saltus_firing firings[2];
        static saltus_pilot pilot;
        saltus_pilot *leads = run % 2 ? &pilot : NULL;
        memset(&lying, 0, sizeof lying);
        memset(&readings, 0, sizeof readings);
        draw_senses();
        draw_plane();
        draw_balance();
        draw_lead();
        saltus_rotation attitude = lie();
        saltus_real place[3];
        vector(place);
        saltus_estimator_start(&estimator, &senses, &attitude, place);
        saltus_balancer_start(&balancer, &balance, &plane);
        saltus_pilot_start(&pilot, &lead, planes, PLANES, (const saltus_real(*)[2])path, POINTS);
        saltus_real course = between(N(-3.0), N(3.0));
        for (uint32_t k = 0; k < RUN; k++) {
            tumble(&readings);
            see(&sight, &estimator.estimate, course);
            sight.touching = readings.touching;
            if (k % 101 == 0) {
                uint32_t used = stack_of(&estimator, &balancer, leads, &readings, &sight);
                if (used > most) most = used;
            }
            from = now();
            cycle(&estimator, &balancer, leads, &readings, &sight, &lying, firings);
            count(instructions(from, now()));
            fired += firings[0].leg >= 0 || firings[1].leg >= 0;
            mix(&estimator.estimate, &lying, firings);
            if (leads) mix_word((uint32_t)saltus_pilot_plane(leads));
        }
        starts += leads ? pilot.starts : 0;
    }
    report("balls", CYCLES, fired, hash);
    printf("knew how it lay in %lu of %lu runs, set out %lu times\n", (unsigned long)knew, (unsigned long)(CYCLES / RUN), (unsigned long)starts);
#ifdef __arm__
    printf("# stack of a ball's cycle: at most %lu bytes\n", (unsigned long)most);
    printf("# memory of a ball: %lu bytes\n", (unsigned long)(sizeof(saltus_estimator) + sizeof(saltus_pilot)));
#else
    (void)most;
#endif
    return 0;
}
