//! Messages as bytes: CDR, the encoding of ROS 2 (OMG, Common Data Representation 1.1: XCDR 1).

/// Bytes before the first field: plain CDR, little endian, no options.
const HEAD: [u8; 4] = [0, 1, 0, 0];

/// Writes one message after the other into one buffer.
#[derive(Clone, Debug)]
pub struct Encoder {
    bytes: Vec<u8>,
}

impl Default for Encoder {
    fn default() -> Encoder {
        Encoder::new()
    }
}

impl Encoder {
    /// An empty message.
    pub fn new() -> Encoder {
        Encoder {
            bytes: HEAD.to_vec(),
        }
    }

    /// Begins a new message.
    pub fn clear(&mut self) -> &mut Encoder {
        self.bytes.truncate(HEAD.len());
        self
    }

    /// The message.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Numbers stand at multiples of their size from the first field.
    fn align(&mut self, size: usize) {
        let past = (self.bytes.len() - HEAD.len()) % size;
        if past > 0 {
            self.bytes.resize(self.bytes.len() + size - past, 0);
        }
    }

    /// An `uint8`, or a `bool`.
    pub fn u8(&mut self, x: u8) -> &mut Encoder {
        self.bytes.push(x);
        self
    }

    /// An `int32`.
    pub fn i32(&mut self, x: i32) -> &mut Encoder {
        self.align(4);
        self.bytes.extend(x.to_le_bytes());
        self
    }

    /// An `uint32`.
    pub fn u32(&mut self, x: u32) -> &mut Encoder {
        self.align(4);
        self.bytes.extend(x.to_le_bytes());
        self
    }

    /// A `float32`.
    pub fn f32(&mut self, x: f32) -> &mut Encoder {
        self.align(4);
        self.bytes.extend(x.to_le_bytes());
        self
    }

    /// A `float64`.
    pub fn f64(&mut self, x: f64) -> &mut Encoder {
        self.align(8);
        self.bytes.extend(x.to_le_bytes());
        self
    }

    /// A `float64[N]`, or fields of one type each after the other.
    pub fn f64s(&mut self, list: &[f64]) -> &mut Encoder {
        for x in list {
            self.f64(*x);
        }
        self
    }

    /// The length of a sequence, which its elements follow.
    ///
    /// # Panics
    /// For more than 2³² − 1 elements.
    pub fn length(&mut self, length: usize) -> &mut Encoder {
        self.u32(u32::try_from(length).expect("a sequence of a message has fewer elements"))
    }

    /// A `float64[]`.
    pub fn sequence(&mut self, list: &[f64]) -> &mut Encoder {
        self.length(list.len()).f64s(list)
    }

    /// A `string`, whose zero byte at the end counts.
    pub fn string(&mut self, text: &str) -> &mut Encoder {
        self.length(text.len() + 1);
        self.bytes.extend(text.as_bytes());
        self.u8(0)
    }
}
