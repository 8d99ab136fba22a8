//! Long columns of numbers as text that a page's script turns into typed arrays: little-endian numbers in base64.

use serde_json::{Value, json};

/// The greatest of the whole numbers that stand for the numbers of [`shares`].
const MOST: f64 = i16::MAX as f64;

/// `bytes` in base64 (RFC 4648, with padding).
pub(super) fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let at = |k: usize| u32::from(group.get(k).copied().unwrap_or_default());
        let bits = at(0) << 16 | at(1) << 8 | at(2);
        for k in 0..4 {
            if k <= group.len() {
                let digit = bits >> (18 - 6 * k) & 63;
                text.push(char::from(DIGITS[digit as usize]));
            } else {
                text.push('=');
            }
        }
    }
    text
}

/// Numbers of 32 bits.
pub(crate) fn floats(numbers: &[f64]) -> Value {
    // Nearest is what is wanted.
    #[allow(clippy::cast_possible_truncation)]
    let bytes = numbers.iter().flat_map(|x| (*x as f32).to_le_bytes());
    Value::from(base64(&bytes.collect::<Vec<u8>>()))
}

/// Numbers from −`most` to `most` as shares of it, each of 16 bits: off by `most` / 65534 at most.
pub(crate) fn shares(numbers: &[f64], most: f64) -> Value {
    let scale = if most > 0.0 { MOST / most } else { 0.0 };
    // Within the range, and a cast of what is not ends at its ends.
    #[allow(clippy::cast_possible_truncation)]
    let whole = numbers.iter().map(|x| (x * scale).round() as i16);
    let bytes: Vec<u8> = whole.flat_map(i16::to_le_bytes).collect();
    json!({ "most": most, "share": base64(&bytes) })
}

/// Whole numbers from 0 to 255.
pub(crate) fn bytes(numbers: &[u8]) -> Value {
    Value::from(base64(numbers))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        // RFC 4648, section 10.
        for (text, coded) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(text.as_bytes()), coded);
        }
        assert_eq!(base64(&[0xff, 0xef, 0xbe]), "/+++");
    }

    #[test]
    fn shares_round_to_the_nearest_and_end_at_the_greatest() {
        // 32767, −16384 (−16383.5 away from zero) and 0, low byte first.
        let packed = shares(&[2.0, -1.0, 0.0], 2.0);
        assert_eq!(
            packed["share"],
            base64(&[0xff, 0x7f, 0x00, 0xc0, 0x00, 0x00])
        );
        assert_eq!(shares(&[0.0], 0.0)["share"], base64(&[0, 0]));
        assert_eq!(floats(&[1.0]), base64(&[0, 0, 0x80, 0x3f]));
    }
}
