//! Motion by classical Runge–Kutta steps.

/// Air at rest: gravity (m/s²), ambient pressure (Pa), temperature (K).
pub(super) const GRAVITY: f64 = 9.80665;
/// See [`GRAVITY`].
pub(super) const AMBIENT: f64 = 101_325.0;
/// Heat ratio and gas constant (J/(kg K)) of air and of carbon dioxide.
pub(super) const AIR: (f64, f64) = (1.4, 287.05);
/// See [`AIR`].
pub(super) const CARBON_DIOXIDE: (f64, f64) = (1.289, 188.924);
/// Pascals in a pound per square inch.
pub(super) const PSI: f64 = 6894.757293168;

/// The state after `h` seconds, where its rate is `f` of time and state.
pub(super) fn rk4<const N: usize>(
    f: impl Fn(f64, &[f64; N]) -> [f64; N],
    t: f64,
    y: &[f64; N],
    h: f64,
) -> [f64; N] {
    let along = |k: &[f64; N], h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
    let k1 = f(t, y);
    let k2 = f(t + 0.5 * h, &along(&k1, 0.5 * h));
    let k3 = f(t + 0.5 * h, &along(&k2, 0.5 * h));
    let k4 = f(t + h, &along(&k3, h));
    std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
}

/// The least `h` up to `whole` at which `crossed` holds, which it does at `whole`, to round-off.
pub(super) fn first(whole: f64, crossed: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, whole);
    for _ in 0..48 {
        let middle = 0.5 * (low + high);
        if crossed(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// Ratio of pressures from which a flow is laminar: proportional to their difference.
const LAMINAR: f64 = 0.9995;

/// Mass flow (kg/s) of an ideal gas at `t` kelvin through an effective `area` (m²) from `up` to
/// `down` (Pa), negative backwards.
///
/// St Venant and Wantzel, in the isentropic exit speed and density: ρ_e w_e A.
pub(super) fn nozzle(area: f64, (kappa, gas): (f64, f64), t: f64, up: f64, down: f64) -> f64 {
    if down > up {
        return -nozzle(area, (kappa, gas), t, down, up);
    }
    if down > LAMINAR * up {
        // As the root of what is left its rate would be infinite where the pressures meet.
        let part = (1.0 - down / up) / (1.0 - LAMINAR);
        return part * nozzle(area, (kappa, gas), t, up, LAMINAR * up);
    }
    let critical = (2.0 / (kappa + 1.0)).powf(kappa / (kappa - 1.0));
    let ratio = (down / up).max(critical);
    let density = up / (gas * t) * ratio.powf(1.0 / kappa);
    let cooling = 1.0 - ratio.powf((kappa - 1.0) / kappa);
    area * density * (2.0 * kappa / (kappa - 1.0) * gas * t * cooling.max(0.0)).sqrt()
}
