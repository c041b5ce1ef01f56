//! Colors that say what they hold: light in proportion, encoded for a screen, or as the eye compares them.

use core::fmt;
use core::str::FromStr;

/// Light in proportion to energy, with sRGB's primaries: 0 is none, 1 is paper white. What paint is computed in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinearRgb(pub [f64; 3]);

/// A color as screens and files hold it: sRGB, encoded, 0..=1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Srgb(pub [f64; 3]);

/// CIE L\*a\*b\* under D65: differences are roughly as the eye sees them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lab {
    /// Lightness, 0 black to 100 white.
    pub l: f64,
    /// Green (negative) to red.
    pub a: f64,
    /// Blue (negative) to yellow.
    pub b: f64,
}

/// A text that is no hexadecimal color.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` is not a color such as `#c0392b` or `#c32`")]
pub struct BadHex {
    /// The text.
    pub text: String,
}

/// Decodes one sRGB channel to linear light; odd about 0, so values outside 0..=1 pass through.
///
/// # Source
/// IEC 61966-2-1.
pub fn decode_srgb(encoded: f64) -> f64 {
    let size = encoded.abs();
    let linear = if size <= 0.04045 { size / 12.92 } else { libm::pow((size + 0.055) / 1.055, 2.4) };
    linear.copysign(encoded)
}

/// Encodes one channel of linear light as sRGB; odd about 0, so values outside 0..=1 pass through.
///
/// # Source
/// IEC 61966-2-1.
pub fn encode_srgb(linear: f64) -> f64 {
    let size = linear.abs();
    let encoded = if size <= 0.0031308 { size * 12.92 } else { 1.055 * libm::pow(size, 1.0 / 2.4) - 0.055 };
    encoded.copysign(linear)
}

impl LinearRgb {
    /// No light.
    pub const BLACK: Self = Self([0.0; 3]);
    /// A perfect white ground.
    pub const WHITE: Self = Self([1.0; 3]);

    /// The color encoded for a screen.
    pub fn to_srgb(self) -> Srgb {
        Srgb(self.0.map(encode_srgb))
    }

    /// Relative luminance Y, 0..=1.
    pub fn luminance(self) -> f64 {
        dot(XYZ_FROM_LINEAR[1], self.0)
    }

    /// The color in CIE L\*a\*b\*.
    pub fn to_lab(self) -> Lab {
        let [fx, fy, fz] =
            XYZ_FROM_LINEAR.map(|row| lab_curve(dot(row, self.0) / (row[0] + row[1] + row[2])));
        Lab { l: 116.0 * fy - 16.0, a: 500.0 * (fx - fy), b: 200.0 * (fy - fz) }
    }
}

/// XYZ of sRGB's primaries under D65. White is the sum of each row, so that greys have a = b = 0 to rounding.
const XYZ_FROM_LINEAR: [[f64; 3]; 3] =
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]];

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn lab_curve(ratio: f64) -> f64 {
    const BEND: f64 = 6.0 / 29.0;
    if ratio > BEND * BEND * BEND { libm::cbrt(ratio) } else { ratio / (3.0 * BEND * BEND) + 4.0 / 29.0 }
}

impl Srgb {
    /// The color of three bytes.
    pub fn from_bytes(bytes: [u8; 3]) -> Self {
        Self(bytes.map(|byte| f64::from(byte) / 255.0))
    }

    /// The nearest color of three bytes; what is outside 0..=1 is clamped.
    pub fn to_bytes(self) -> [u8; 3] {
        // A float cast saturates, and takes NaN to 0.
        self.0.map(|channel| (channel * 255.0 + 0.5) as u8)
    }

    /// The color decoded to linear light.
    pub fn to_linear(self) -> LinearRgb {
        LinearRgb(self.0.map(decode_srgb))
    }

    /// The color in CIE L\*a\*b\*.
    pub fn to_lab(self) -> Lab {
        self.to_linear().to_lab()
    }
}

impl From<Srgb> for LinearRgb {
    fn from(color: Srgb) -> Self {
        color.to_linear()
    }
}

impl From<LinearRgb> for Srgb {
    fn from(color: LinearRgb) -> Self {
        color.to_srgb()
    }
}

/// Reads `#rrggbb` or `#rgb`, in either case, with or without the `#`.
impl FromStr for Srgb {
    type Err = BadHex;

    fn from_str(text: &str) -> Result<Self, BadHex> {
        let bad = || BadHex { text: text.to_owned() };
        let trimmed = text.trim();
        let digits: Vec<u8> = trimmed
            .strip_prefix('#')
            .unwrap_or(trimmed)
            .chars()
            .map(|digit| digit.to_digit(16).map(|value| value as u8).ok_or_else(bad))
            .collect::<Result<_, _>>()?;
        match digits[..] {
            [r, g, b] => Ok(Self::from_bytes([r * 17, g * 17, b * 17])),
            [r1, r0, g1, g0, b1, b0] => Ok(Self::from_bytes([r1 * 16 + r0, g1 * 16 + g0, b1 * 16 + b0])),
            _ => Err(bad()),
        }
    }
}

/// Writes `#rrggbb`.
impl fmt::Display for Srgb {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [r, g, b] = self.to_bytes();
        write!(f, "#{r:02x}{g:02x}{b:02x}")
    }
}

impl Lab {
    /// How different two colors look: ΔE00. About 1 is just visible side by side.
    ///
    /// # Source
    /// Sharma, Wu, Dalal 2005, *The CIEDE2000 color-difference formula*, equations 2 to 22.
    pub fn ciede2000(self, other: Self) -> f64 {
        const POW_25_7: f64 = 6_103_515_625.0;
        let chroma_weight = |chroma: f64| {
            let c7 = libm::pow(chroma, 7.0);
            libm::sqrt(c7 / (c7 + POW_25_7))
        };
        let g =
            0.5 * (1.0 - chroma_weight(0.5 * (libm::hypot(self.a, self.b) + libm::hypot(other.a, other.b))));
        // C', h' (degrees) of a color whose a is stretched near grey.
        let polar = |color: Self| {
            let a = (1.0 + g) * color.a;
            let hue = libm::atan2(color.b, a).to_degrees();
            (libm::hypot(a, color.b), if hue < 0.0 { hue + 360.0 } else { hue })
        };
        let ((c1, h1), (c2, h2)) = (polar(self), polar(other));
        let grey = c1 * c2 == 0.0;

        let turn = match h2 - h1 {
            _ if grey => 0.0,
            turn if turn > 180.0 => turn - 360.0,
            turn if turn < -180.0 => turn + 360.0,
            turn => turn,
        };
        let dl = other.l - self.l;
        let dc = c2 - c1;
        let dh = 2.0 * libm::sqrt(c1 * c2) * libm::sin((0.5 * turn).to_radians());

        let l = 0.5 * (self.l + other.l);
        let c = 0.5 * (c1 + c2);
        let h = match h1 + h2 {
            sum if grey => sum,
            sum if (h1 - h2).abs() <= 180.0 => 0.5 * sum,
            sum if sum < 360.0 => 0.5 * (sum + 360.0),
            sum => 0.5 * (sum - 360.0),
        };
        let cosine = |degrees: f64| libm::cos(degrees.to_radians());
        let t = 1.0 - 0.17 * cosine(h - 30.0) + 0.24 * cosine(2.0 * h) + 0.32 * cosine(3.0 * h + 6.0)
            - 0.20 * cosine(4.0 * h - 63.0);
        let off = (l - 50.0) * (l - 50.0);
        let sl = 1.0 + 0.015 * off / libm::sqrt(20.0 + off);
        let sc = 1.0 + 0.045 * c;
        let sh = 1.0 + 0.015 * c * t;
        let blue = (h - 275.0) / 25.0;
        let rotation = -libm::sin((60.0 * libm::exp(-blue * blue)).to_radians()) * 2.0 * chroma_weight(c);
        let (dl, dc, dh) = (dl / sl, dc / sc, dh / sh);
        // The quadratic form is positive definite for |rotation| < 2; only rounding takes it below 0.
        libm::sqrt((dl * dl + dc * dc + dh * dh + rotation * dc * dh).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn transfer_has_the_standards_fixed_points() {
        assert_eq!(encode_srgb(0.0), 0.0);
        assert!((encode_srgb(1.0) - 1.0).abs() < 1e-15);
        assert!((decode_srgb(1.0) - 1.0).abs() < 1e-15);
        assert!((decode_srgb(0.5) - 0.214_041_140_482).abs() < 1e-11);
        assert!((encode_srgb(-0.2) + encode_srgb(0.2)).abs() == 0.0);
    }

    #[test]
    fn every_byte_survives_linear_light() {
        for byte in 0..=255 {
            let color = Srgb::from_bytes([byte, 255 - byte, byte / 2]);
            assert_eq!(color.to_linear().to_srgb().to_bytes(), [byte, 255 - byte, byte / 2]);
        }
    }

    #[test]
    fn hex_is_read_in_both_lengths() {
        assert_eq!("#C0392b".parse::<Srgb>().unwrap().to_bytes(), [0xc0, 0x39, 0x2b]);
        assert_eq!("c32".parse::<Srgb>().unwrap().to_string(), "#cc3322");
        for bad in ["", "#", "#12", "#1234", "#12345g", "#12345678", "##12345", "#é23", "red"] {
            assert_eq!(bad.parse::<Srgb>(), Err(BadHex { text: bad.to_owned() }));
        }
    }

    #[test]
    fn bytes_saturate() {
        assert_eq!(Srgb([-1.0, 7.0, f64::NAN]).to_bytes(), [0, 255, 0]);
    }

    #[test]
    fn lab_of_known_colors() {
        let close = |hex: &str, l: f64, a: f64, b: f64| {
            let lab = hex.parse::<Srgb>().unwrap().to_lab();
            let off = (lab.l - l).abs().max((lab.a - a).abs()).max((lab.b - b).abs());
            assert!(off < 0.01, "{hex}: {lab:?}");
        };
        close("#ffffff", 100.0, 0.0, 0.0);
        close("#000000", 0.0, 0.0, 0.0);
        close("#777777", 50.034, 0.0, 0.0);
        close("#ff0000", 53.241, 80.092, 67.203);
        close("#0000ff", 32.297, 79.188, -107.860);
    }

    /// Pairs of Sharma, Wu, Dalal 2005, table 1: L, a, b of both and ΔE00.
    const SHARMA: [[f64; 7]; 34] = [
        [50.0, 2.6772, -79.7751, 50.0, 0.0, -82.7485, 2.0425],
        [50.0, 3.1571, -77.2803, 50.0, 0.0, -82.7485, 2.8615],
        [50.0, 2.8361, -74.0200, 50.0, 0.0, -82.7485, 3.4412],
        [50.0, -1.3802, -84.2814, 50.0, 0.0, -82.7485, 1.0000],
        [50.0, -1.1848, -84.8006, 50.0, 0.0, -82.7485, 1.0000],
        [50.0, -0.9009, -85.5211, 50.0, 0.0, -82.7485, 1.0000],
        [50.0, 0.0, 0.0, 50.0, -1.0, 2.0, 2.3669],
        [50.0, -1.0, 2.0, 50.0, 0.0, 0.0, 2.3669],
        [50.0, 2.4900, -0.0010, 50.0, -2.4900, 0.0009, 7.1792],
        [50.0, 2.4900, -0.0010, 50.0, -2.4900, 0.0010, 7.1792],
        [50.0, 2.4900, -0.0010, 50.0, -2.4900, 0.0011, 7.2195],
        [50.0, 2.4900, -0.0010, 50.0, -2.4900, 0.0012, 7.2195],
        [50.0, -0.0010, 2.4900, 50.0, 0.0009, -2.4900, 4.8045],
        [50.0, -0.0010, 2.4900, 50.0, 0.0010, -2.4900, 4.8045],
        [50.0, -0.0010, 2.4900, 50.0, 0.0011, -2.4900, 4.7461],
        [50.0, 2.5, 0.0, 50.0, 0.0, -2.5, 4.3065],
        [50.0, 2.5, 0.0, 73.0, 25.0, -18.0, 27.1492],
        [50.0, 2.5, 0.0, 61.0, -5.0, 29.0, 22.8977],
        [50.0, 2.5, 0.0, 56.0, -27.0, -3.0, 31.9030],
        [50.0, 2.5, 0.0, 58.0, 24.0, 15.0, 19.4535],
        [50.0, 2.5, 0.0, 50.0, 3.1736, 0.5854, 1.0000],
        [50.0, 2.5, 0.0, 50.0, 3.2972, 0.0, 1.0000],
        [50.0, 2.5, 0.0, 50.0, 1.8634, 0.5757, 1.0000],
        [50.0, 2.5, 0.0, 50.0, 3.2592, 0.3350, 1.0000],
        [60.2574, -34.0099, 36.2677, 60.4626, -34.1751, 39.4387, 1.2644],
        [63.0109, -31.0961, -5.8663, 62.8187, -29.7946, -4.0864, 1.2630],
        [61.2901, 3.7196, -5.3901, 61.4292, 2.2480, -4.9620, 1.8731],
        [35.0831, -44.1164, 3.7933, 35.0232, -40.0716, 1.5901, 1.8645],
        [22.7233, 20.0904, -46.6940, 23.0331, 14.9730, -42.5619, 2.0373],
        [36.4612, 47.8580, 18.3852, 36.2715, 50.5065, 21.2231, 1.4146],
        [90.8027, -2.0831, 1.4410, 91.1528, -1.6435, 0.0447, 1.4441],
        [90.9257, -0.5406, -0.9208, 88.6381, -0.8985, -0.7239, 1.5381],
        [6.7747, -0.2908, -2.4247, 5.8714, -0.0985, -2.2286, 0.6377],
        [2.0776, 0.0795, -1.1350, 0.9033, -0.0636, -0.5514, 0.9082],
    ];

    #[test]
    fn ciede2000_matches_the_published_pairs() {
        for [l1, a1, b1, l2, a2, b2, difference] in SHARMA {
            let (first, second) = (Lab { l: l1, a: a1, b: b1 }, Lab { l: l2, a: a2, b: b2 });
            for got in [first.ciede2000(second), second.ciede2000(first)] {
                assert!((got - difference).abs() < 5.1e-5, "{first:?} {second:?}: {got}, not {difference}");
            }
        }
    }

    proptest! {
        #[test]
        fn hex_of_every_color_is_read_back(bytes: [u8; 3]) {
            let text = Srgb::from_bytes(bytes).to_string();
            prop_assert_eq!(text.parse::<Srgb>().unwrap().to_bytes(), bytes);
        }

        #[test]
        fn no_text_makes_the_hex_parser_panic(text in "\\PC{0,12}|#[0-9a-gA-Gé]{0,9}") {
            let _ = text.parse::<Srgb>();
        }

        #[test]
        fn transfer_round_trips(linear in -2.0f64..4.0) {
            // The standard's two pieces meet only to 1e-8 at the bend.
            prop_assert!((decode_srgb(encode_srgb(linear)) - linear).abs() < 1e-8);
        }

        #[test]
        fn a_color_differs_from_itself_by_nothing(l in 0.0f64..100.0, a in -99.0f64..99.0, b in -99.0f64..99.0) {
            let lab = Lab { l, a, b };
            prop_assert_eq!(lab.ciede2000(lab), 0.0);
        }
    }
}
