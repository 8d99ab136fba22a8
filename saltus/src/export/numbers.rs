//! The controller's numbers as text and bytes.

use saltus_controller::Real;

/// A number of a controller that can be written.
pub trait Number: Real + std::fmt::Display {
    /// Its bytes, least first.
    type Bytes: AsRef<[u8]>;

    /// C's type.
    const C_TYPE: &'static str;
    /// Rust's type.
    const RUST_TYPE: &'static str;
    /// Whether it is C's float.
    const IS_FLOAT: bool;

    /// As `f64`.
    fn wide(self) -> f64;

    /// Its bytes, least first.
    fn bytes(self) -> Self::Bytes;

    /// The shortest digits that read back as it, with a point or an exponent.
    fn digits(self) -> String;

    /// As a constant of C.
    fn c(self) -> String {
        if Self::IS_FLOAT {
            format!("{}f", self.digits())
        } else {
            self.digits()
        }
    }
}

macro_rules! number {
    ($type:ty, $bytes:literal, $c:literal, $float:literal) => {
        impl Number for $type {
            type Bytes = [u8; $bytes];
            const C_TYPE: &'static str = $c;
            const RUST_TYPE: &'static str = stringify!($type);
            const IS_FLOAT: bool = $float;

            #[allow(clippy::cast_lossless)]
            fn wide(self) -> f64 {
                self as f64
            }

            fn bytes(self) -> [u8; $bytes] {
                self.to_le_bytes()
            }

            fn digits(self) -> String {
                format!("{self:?}")
            }
        }
    };
}

number!(f32, 4, "float", true);
number!(f64, 8, "double", false);
