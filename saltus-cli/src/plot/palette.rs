//! Colours.

use plotters::style::RGBColor;

/// Text, axes, the ground.
pub(crate) const INK: RGBColor = RGBColor(40, 40, 40);
/// Grid lines.
pub(crate) const FAINT: RGBColor = RGBColor(226, 226, 226);
/// What stands in the background.
pub(crate) const GREY: RGBColor = RGBColor(150, 150, 150);
/// The first colour of lines.
pub(crate) const BLUE: RGBColor = RGBColor(31, 99, 168);
/// What holds, and where to land.
pub(crate) const GREEN: RGBColor = RGBColor(60, 150, 80);
/// What must not be missed.
pub(crate) const RED: RGBColor = RGBColor(200, 50, 40);

/// Viridis (Smith, van der Walt; CC0) at equal steps.
const VIRIDIS: [(u8, u8, u8); 9] = [
    (68, 1, 84),
    (71, 44, 122),
    (59, 81, 139),
    (44, 113, 142),
    (33, 144, 141),
    (39, 173, 129),
    (92, 200, 99),
    (170, 220, 50),
    (253, 231, 37),
];

/// The colour of one of `count` lines, from dark to bright, its number from 0; [`BLUE`] alone.
pub(crate) fn shade(number: usize, count: usize) -> RGBColor {
    match count {
        0 | 1 => BLUE,
        _ => viridis(0.88 * number as f64 / (count - 1) as f64),
    }
}

/// The colour for `share` in [0, 1], from dark to bright.
pub(crate) fn viridis(share: f64) -> RGBColor {
    let steps = VIRIDIS.len() - 1;
    let place = share.clamp(0.0, 1.0) * steps as f64;
    // Within 0..steps by the clamp.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let below = (place as usize).min(steps - 1);
    let part = place - below as f64;
    let (a, b) = (VIRIDIS[below], VIRIDIS[below + 1]);
    // Between two bytes lies a byte.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let mix = |a: u8, b: u8| (f64::from(a) * (1.0 - part) + f64::from(b) * part).round() as u8;
    RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}
