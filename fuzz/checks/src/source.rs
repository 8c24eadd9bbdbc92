//! Choices and numbers from bytes; zeros once the bytes have ended, so that every input means something.

/// Bytes that choices are read from.
#[derive(Clone, Debug)]
pub struct Source<'a> {
    bytes: &'a [u8],
}

/// Numbers at the edges of doubles.
const EXTREMES: [f64; 14] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    f64::MIN_POSITIVE,
    -1e-310,
    5e-324,
    f64::MAX,
    -1e300,
    1e154,
    1e-154,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
];

impl<'a> Source<'a> {
    /// Reads from the first byte on.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes }
    }

    /// Whether every byte is read.
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// The bytes that are not read yet.
    pub fn rest(self) -> &'a [u8] {
        self.bytes
    }

    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.bytes.split_first() else {
            return 0;
        };
        self.bytes = rest;
        *first
    }

    fn word(&mut self) -> u16 {
        u16::from_le_bytes([self.byte(), self.byte()])
    }

    /// 0 … count − 1, for a count of 1 to 65536.
    pub fn below(&mut self, count: usize) -> usize {
        match count {
            0 | 1 => 0,
            2..=256 => usize::from(self.byte()) * count / 256,
            _ => usize::from(self.word()) * count / 65536,
        }
    }

    /// True for about `parts` of 256 bytes.
    pub fn chance(&mut self, parts: u8) -> bool {
        self.byte() >= 255 - parts.saturating_sub(1)
    }

    /// One of `items`.
    ///
    /// # Panics
    /// When there are none.
    pub fn pick<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())]
    }

    /// A number between `low` and `high` on a grid of 65536 points.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.word()) / 65536.0
    }

    /// The same rounded to two decimals, as a person would write it.
    pub fn decimal(&mut self, low: f64, high: f64) -> f64 {
        (100.0 * self.between(low, high)).round() / 100.0
    }

    /// Any double, often one at the edges.
    pub fn double(&mut self) -> f64 {
        match self.below(4) {
            0 => self.pick(&EXTREMES),
            1 => {
                let mut bytes = [0; 8];
                bytes.fill_with(|| self.byte());
                f64::from_le_bytes(bytes)
            }
            _ => self.between(-4.0, 4.0),
        }
    }
}

/// A stream of bytes that depends on a seed and a number alone: SplitMix64 (Steele, Lea, Flood 2014).
pub fn random_bytes(seed: u64, index: u64, count: usize) -> Vec<u8> {
    let mixed = |mut z: u64| {
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    };
    let start = mixed(seed).wrapping_add(mixed(index ^ 0x5851_F42D_4C95_7F2D));
    let words = (1..=count.div_ceil(8) as u64)
        .map(|k| mixed(start.wrapping_add(k.wrapping_mul(0x9E37_79B9_7F4A_7C15))));
    words.flat_map(u64::to_le_bytes).take(count).collect()
}
