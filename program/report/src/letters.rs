//! Letters of the fonts that every reader of PDF has, and their widths.

use pdf_writer::Name;

/// Fonts: one of Latin letters, one of Greek letters and signs.
pub(super) const LATIN: Name<'static> = Name(b"F1");
pub(super) const SYMBOL: Name<'static> = Name(b"F2");

/// The size of raised and lowered letters, and by how much they are moved, over that of the others.
pub(super) const SMALL: f32 = 0.68;
const RAISED: f32 = 0.36;
const LOWERED: f32 = -0.16;

/// Widths of Helvetica's letters from the space to the tilde, in thousandths of its size (Adobe's metrics).
const WIDTHS: [u16; 95] = [
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556, 556,
    556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667,
    611, 778, 722, 278, 500, 667, 556, 833, 722, 778, 667, 778, 722, 667, 611, 722, 667, 944, 667,
    667, 611, 278, 278, 278, 469, 556, 333, 556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500,
    222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584,
];

/// Width of the letters whose own is not known here.
const USUAL: u16 = 556;

/// Letters of the font of symbols by their places in it.
const SYMBOLS: [(char, u8); 45] = [
    ('α', b'a'),
    ('β', b'b'),
    ('γ', b'g'),
    ('δ', b'd'),
    ('ε', b'e'),
    ('ζ', b'z'),
    ('η', b'h'),
    ('θ', b'q'),
    ('ι', b'i'),
    ('κ', b'k'),
    ('λ', b'l'),
    ('μ', b'm'),
    ('ν', b'n'),
    ('ξ', b'x'),
    ('ο', b'o'),
    ('π', b'p'),
    ('ρ', b'r'),
    ('σ', b's'),
    ('τ', b't'),
    ('υ', b'u'),
    ('φ', b'f'),
    ('ϕ', b'j'),
    ('χ', b'c'),
    ('ψ', b'y'),
    ('ω', b'w'),
    ('Γ', b'G'),
    ('Δ', b'D'),
    ('Θ', b'Q'),
    ('Λ', b'L'),
    ('Ξ', b'X'),
    ('Π', b'P'),
    ('Σ', b'S'),
    ('Φ', b'F'),
    ('Ψ', b'Y'),
    ('Ω', b'W'),
    ('−', 0x2D),
    ('∂', 0xB6),
    ('∞', 0xA5),
    ('√', 0xD6),
    ('≤', 0xA3),
    ('≥', 0xB3),
    ('∝', 0xB5),
    ('→', 0xAE),
    ('≈', 0xBB),
    ('∇', 0xD1),
];

/// Raised and lowered digits and signs, as the letters that they are.
const MOVED: [(char, char, f32); 24] = [
    ('⁰', '0', RAISED),
    ('¹', '1', RAISED),
    ('²', '2', RAISED),
    ('³', '3', RAISED),
    ('⁴', '4', RAISED),
    ('⁵', '5', RAISED),
    ('⁶', '6', RAISED),
    ('⁷', '7', RAISED),
    ('⁸', '8', RAISED),
    ('⁹', '9', RAISED),
    ('⁺', '+', RAISED),
    ('⁻', '−', RAISED),
    ('₀', '0', LOWERED),
    ('₁', '1', LOWERED),
    ('₂', '2', LOWERED),
    ('₃', '3', LOWERED),
    ('₄', '4', LOWERED),
    ('₅', '5', LOWERED),
    ('₆', '6', LOWERED),
    ('₇', '7', LOWERED),
    ('₈', '8', LOWERED),
    ('₉', '9', LOWERED),
    ('ⁿ', 'n', RAISED),
    ('ᵀ', 'T', RAISED),
];

/// A letter in its font.
pub(super) struct Glyph {
    pub(super) font: Name<'static>,
    pub(super) code: u8,
    /// Over the size of the text.
    pub(super) width: f32,
    /// Where it is moved, its shift over the size of the text.
    pub(super) shift: Option<f32>,
}

/// A letter in a font that has it.
pub(super) fn glyph(letter: char) -> Option<Glyph> {
    if let Some((_, plain, shift)) = MOVED.iter().find(|(moved, ..)| *moved == letter) {
        let plain = glyph(*plain)?;
        return Some(Glyph {
            width: plain.width * SMALL,
            shift: Some(*shift),
            ..plain
        });
    }
    let of = |font, code, width: u16| {
        Some(Glyph {
            font,
            code,
            width: f32::from(width) / 1000.0,
            shift: None,
        })
    };
    if let Some((_, code)) = SYMBOLS.iter().find(|(symbol, _)| *symbol == letter) {
        return of(SYMBOL, *code, USUAL);
    }
    let code = u32::from(letter);
    match letter {
        ' '..='~' => of(LATIN, code as u8, WIDTHS[code as usize - 32]),
        '\u{a0}'..='\u{ff}' => of(LATIN, code as u8, USUAL),
        '–' => of(LATIN, 0x96, USUAL),
        '’' => of(LATIN, 0x92, 222),
        '…' => of(LATIN, 0x85, 1000),
        _ => None,
    }
}

/// The width of a text in logical pixels, at its size; letters of no font count as usual ones.
pub(super) fn width_of(text: &str, size: f64) -> f64 {
    let widths = text
        .chars()
        .map(|letter| glyph(letter).map_or(0.6, |glyph| f64::from(glyph.width)));
    size * widths.sum::<f64>()
}
