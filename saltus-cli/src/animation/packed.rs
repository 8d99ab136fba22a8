//! Long columns of numbers as text that a page's script turns into typed arrays: little-endian numbers in base64.

use base64::prelude::{BASE64_STANDARD as STANDARD, Engine as _};
use serde_json::{Value, json};

/// The greatest of the whole numbers that stand for the numbers of [`shares`].
const MOST: f64 = i16::MAX as f64;

/// Numbers of 32 bits.
pub(crate) fn floats(numbers: &[f64]) -> Value {
    // Nearest is what is wanted.
    #[allow(clippy::cast_possible_truncation)]
    let bytes = numbers.iter().flat_map(|x| (*x as f32).to_le_bytes());
    Value::from(STANDARD.encode(bytes.collect::<Vec<u8>>()))
}

/// Numbers from −`most` to `most` as shares of it, each of 16 bits: off by `most` / 65534 at most.
pub(crate) fn shares(numbers: &[f64], most: f64) -> Value {
    let scale = if most > 0.0 { MOST / most } else { 0.0 };
    // Within the range, and a cast of what is not ends at its ends.
    #[allow(clippy::cast_possible_truncation)]
    let whole = numbers.iter().map(|x| (x * scale).round() as i16);
    let bytes: Vec<u8> = whole.flat_map(i16::to_le_bytes).collect();
    json!({ "most": most, "share": STANDARD.encode(&bytes) })
}

/// Whole numbers from 0 to 255.
pub(crate) fn bytes(numbers: &[u8]) -> Value {
    Value::from(STANDARD.encode(numbers))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_round_to_the_nearest_and_end_at_the_greatest() {
        // 32767, −16384 (−16383.5 away from zero) and 0, low byte first.
        let packed = shares(&[2.0, -1.0, 0.0], 2.0);
        assert_eq!(
            packed["share"],
            STANDARD.encode([0xff, 0x7f, 0x00, 0xc0, 0x00, 0x00])
        );
        assert_eq!(shares(&[0.0], 0.0)["share"], STANDARD.encode([0, 0]));
        assert_eq!(floats(&[1.0]), STANDARD.encode([0, 0, 0x80, 0x3f]));
    }
}
