//! The font of figures.

use std::sync::OnceLock;

use ttf_parser::Face;

pub(crate) const FAMILY: &str = "Liberation Sans";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// Of texts.
    Regular,
    /// Of headings, and of what is certain.
    Bold,
}

impl Weight {
    pub(crate) const ALL: [Self; 2] = [Self::Regular, Self::Bold];

    /// Its number in styles.
    pub(crate) fn number(self) -> u16 {
        match self {
            Self::Regular => 400,
            Self::Bold => 700,
        }
    }

    /// Its file.
    pub(crate) fn data(self) -> &'static [u8] {
        match self {
            Self::Regular => include_bytes!("../fonts/LiberationSans-Regular.ttf"),
            Self::Bold => include_bytes!("../fonts/LiberationSans-Bold.ttf"),
        }
    }

    /// Its face; none if the file is damaged, which the tests would tell.
    pub(crate) fn face(self) -> Option<Face<'static>> {
        Face::parse(self.data(), 0).ok()
    }
}

/// How wide a text is on one line, in multiples of the font's size. A character that the font lacks counts as one em.
#[must_use]
pub fn text_width(text: &str, weight: Weight) -> f64 {
    static FACES: OnceLock<[Option<Face<'static>>; 2]> = OnceLock::new();
    let faces = FACES.get_or_init(|| Weight::ALL.map(Weight::face));
    let Some(face) = &faces[weight as usize] else { return 0.6 * text.chars().count() as f64 };
    let units = f64::from(face.units_per_em());
    let advance = |c: char| face.glyph_index(c).and_then(|g| face.glyph_hor_advance(g)).map(f64::from);
    text.chars().map(|c| advance(c).unwrap_or(units)).sum::<f64>() / units
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_as_wide_as_in_helvetica() {
        // Adobe's metrics of Helvetica (Helvetica.afm): A 667, V 667, a 556, space 278, i 222, in thousandths of an em.
        let width = |t: &str| (1000.0 * text_width(t, Weight::Regular)).round();
        assert_eq!((width("A"), width("a"), width(" "), width("i")), (667.0, 556.0, 278.0, 222.0));
        assert_eq!(width("AV"), 1334.0);
        // Helvetica-Bold.afm: A 722, i 278.
        let bold = |t: &str| (1000.0 * text_width(t, Weight::Bold)).round();
        assert_eq!((bold("A"), bold("i")), (722.0, 278.0));
        assert_eq!(text_width("\u{4e2d}", Weight::Regular), 1.0, "the font has no Chinese");
    }

    #[test]
    fn the_font_has_the_signs_of_figures() {
        for weight in Weight::ALL {
            let face = weight.face().unwrap();
            for c in "aZ09äßéñøλЖ°±×−–—…≤≥%<>&'\"[](){}\u{2009}\u{a0}".chars() {
                // Thin spaces are drawn by no glyph where the font has none, but these are there.
                assert!(face.glyph_index(c).is_some(), "{c:?} of {weight:?}");
            }
        }
    }
}
