//! A part of the font as browsers read it.
//!
//! `subsetter` keeps what a PDF needs of a font. A browser also wants to know which glyph belongs to which character (`cmap`) and
//! the font's metrics (`OS/2`), so both are added here.

use std::collections::BTreeSet;

use subsetter::GlyphRemapper;

use crate::font::Weight;

type Table = ([u8; 4], Vec<u8>);

/// The font with the glyphs of these characters alone, those that it has; none if its file is damaged.
pub(crate) fn part(weight: Weight, characters: &BTreeSet<char>) -> Option<Vec<u8>> {
    let face = weight.face()?;
    let mut glyphs = GlyphRemapper::new();
    let mut map = Vec::new();
    for c in characters {
        if let Some(glyph) = face.glyph_index(*c) {
            map.push((u32::from(*c), glyphs.remap(glyph.0)));
        }
    }
    let subset = subsetter::subset(weight.data(), 0, &glyphs).ok()?;
    let mut tables = read(&subset)?;
    let whole = read(weight.data())?;
    tables.extend(whole.into_iter().filter(|(tag, _)| tag == b"OS/2"));
    tables.push((*b"cmap", cmap(&map)));
    Some(write(tables))
}

/// Which glyph belongs to which character, as format 12 for all of Unicode.
fn cmap(map: &[(u32, u16)]) -> Vec<u8> {
    // Version 0 with one table, of Windows for all of Unicode, which begins at byte 12.
    let mut t = Vec::new();
    [0_u16, 1, 3, 10].iter().for_each(|v| t.extend(v.to_be_bytes()));
    t.extend(12_u32.to_be_bytes());
    // Format and reserved, then length, language and number of groups; here each character is a group.
    [12_u16, 0].iter().for_each(|v| t.extend(v.to_be_bytes()));
    let groups = map.len() as u32;
    [16 + 12 * groups, 0, groups].iter().for_each(|v| t.extend(v.to_be_bytes()));
    for (character, glyph) in map {
        [*character, *character, u32::from(*glyph)].iter().for_each(|v| t.extend(v.to_be_bytes()));
    }
    t
}

fn number(data: &[u8], at: usize) -> Option<usize> {
    let bytes: [u8; 4] = data.get(at..at + 4)?.try_into().ok()?;
    usize::try_from(u32::from_be_bytes(bytes)).ok()
}

/// The tables of a font.
fn read(font: &[u8]) -> Option<Vec<Table>> {
    let count = usize::from(u16::from_be_bytes(font.get(4..6)?.try_into().ok()?));
    (0..count)
        .map(|k| {
            let entry = 12 + 16 * k;
            let tag: [u8; 4] = font.get(entry..entry + 4)?.try_into().ok()?;
            let (offset, length) = (number(font, entry + 8)?, number(font, entry + 12)?);
            Some((tag, font.get(offset..offset.checked_add(length)?)?.to_vec()))
        })
        .collect()
}

/// The sum of its 32-bit words, the last filled up with zeros.
fn checksum(data: &[u8]) -> u32 {
    data.chunks(4).fold(0, |sum, word| {
        let mut whole = [0; 4];
        whole[..word.len()].copy_from_slice(word);
        sum.wrapping_add(u32::from_be_bytes(whole))
    })
}

/// A font of these tables.
fn write(mut tables: Vec<Table>) -> Vec<u8> {
    tables.sort();
    let count = tables.len() as u16;
    let power = count.ilog2() as u16;
    let range = 16 << power;
    let mut font = 0x0001_0000_u32.to_be_bytes().to_vec();
    [count, range, power, 16 * count - range].iter().for_each(|v| font.extend(v.to_be_bytes()));
    let mut offset = 12 + 16 * tables.len();
    let mut adjustment = None;
    for (tag, data) in &mut tables {
        if tag == b"head" && data.len() >= 12 {
            // What makes the sum of the whole right, written at the end.
            data[8..12].fill(0);
            adjustment = Some(offset + 8);
        }
        font.extend(*tag);
        [checksum(data), offset as u32, data.len() as u32].iter().for_each(|v| font.extend(v.to_be_bytes()));
        data.resize(data.len().next_multiple_of(4), 0);
        offset += data.len();
    }
    tables.iter().for_each(|(_, data)| font.extend(data));
    if let Some(at) = adjustment {
        let value = 0xb1b0_afba_u32.wrapping_sub(checksum(&font));
        font[at..at + 4].copy_from_slice(&value.to_be_bytes());
    }
    font
}

#[cfg(test)]
mod tests {
    use super::*;
    use ttf_parser::Face;

    #[test]
    fn a_part_has_the_same_glyphs_for_its_characters_and_no_others() {
        let characters: BTreeSet<char> = "Success −é\u{4e2d}".chars().collect();
        for weight in Weight::ALL {
            let font = part(weight, &characters).unwrap();
            assert!(font.len() < 40_000, "{} bytes", font.len());
            assert_eq!(checksum(&font), 0xb1b0_afba, "the sum that the format prescribes");
            let (own, whole) = (Face::parse(&font, 0).unwrap(), weight.face().unwrap());
            for c in "Suces −é".chars() {
                let (a, b) = (own.glyph_index(c).unwrap(), whole.glyph_index(c).unwrap());
                assert_eq!(own.glyph_hor_advance(a), whole.glyph_hor_advance(b), "{c:?}");
                assert_eq!(own.glyph_bounding_box(a), whole.glyph_bounding_box(b), "{c:?}");
            }
            assert!(own.glyph_index('\u{4e2d}').is_none() && own.glyph_index('Q').is_none());
            assert_eq!(own.ascender(), whole.ascender());
        }
    }
}
