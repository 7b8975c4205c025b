//! The little of Thrift's compact protocol that is needed to look at a Parquet file before a library decodes it.
//!
//! Source: Apache Thrift, `doc/specs/thrift-compact-protocol.md`. Nothing is allocated, and nesting is bounded.

/// Kinds of fields and elements, as the protocol numbers them.
const TRUE: u8 = 1;
const FALSE: u8 = 2;
const BYTE: u8 = 3;
const I16: u8 = 4;
const I32: u8 = 5;
const I64: u8 = 6;
const DOUBLE: u8 = 7;
const BINARY: u8 = 8;
const LIST: u8 = 9;
const SET: u8 = 10;
const MAP: u8 = 11;
const STRUCT: u8 = 12;
const UUID: u8 = 13;

/// Structs and lists within each other at most.
const DEPTH: usize = 32;

/// A cursor over bytes. Every method returns `None` where the bytes end too early or are none of the protocol.
#[derive(Clone, Debug)]
pub(crate) struct Thrift<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Thrift<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// The number of bytes that were read.
    pub(crate) fn position(&self) -> usize {
        self.at
    }

    fn byte(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.at)?;
        self.at += 1;
        Some(byte)
    }

    fn pass(&mut self, count: usize) -> Option<()> {
        let end = self.at.checked_add(count).filter(|end| *end <= self.bytes.len())?;
        self.at = end;
        Some(())
    }

    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f).checked_shl(shift)?;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    /// A whole number of 16, 32 or 64 bits.
    pub(crate) fn number(&mut self) -> Option<i64> {
        let coded = self.varint()?;
        Some((coded >> 1).cast_signed() ^ -(coded & 1).cast_signed())
    }

    /// The head of a list: the number of its elements, each of which has a byte at least, and their kind.
    pub(crate) fn list(&mut self) -> Option<(usize, u8)> {
        let head = self.byte()?;
        let count = match head >> 4 {
            15 => usize::try_from(self.varint()?).ok()?,
            short => short.into(),
        };
        (count <= self.bytes.len() - self.at).then_some((count, head & 0x0f))
    }

    /// Hands each field of a struct (its number and kind) to `take`, which reads its value, or returns `Some(false)` to have it
    /// passed over.
    pub(crate) fn fields(&mut self, mut take: impl FnMut(&mut Self, i64, u8) -> Option<bool>) -> Option<()> {
        let mut number = 0_i64;
        loop {
            let head = self.byte()?;
            if head == 0 {
                return Some(());
            }
            number = match head >> 4 {
                0 => self.number()?,
                step => number.checked_add(step.into())?,
            };
            let kind = head & 0x0f;
            if !take(self, number, kind)? {
                self.skip(kind, DEPTH, false)?;
            }
        }
    }

    /// Passes over a value; within lists, truth values have a byte of their own.
    fn skip(&mut self, kind: u8, depth: usize, in_list: bool) -> Option<()> {
        let depth = depth.checked_sub(1)?;
        match kind {
            TRUE | FALSE => self.pass(usize::from(in_list)),
            BYTE => self.pass(1),
            I16 | I32 | I64 => self.varint().map(drop),
            DOUBLE => self.pass(8),
            UUID => self.pass(16),
            BINARY => {
                let length = self.varint()?;
                self.pass(usize::try_from(length).ok()?)
            }
            LIST | SET => {
                let (count, kind) = self.list()?;
                (0..count).try_for_each(|_| self.skip(kind, depth, true))
            }
            MAP => {
                let count = usize::try_from(self.varint()?).ok()?;
                if count == 0 {
                    return Some(());
                }
                let kinds = self.byte()?;
                (0..count).try_for_each(|_| {
                    self.skip(kinds >> 4, depth, true)?;
                    self.skip(kinds & 0x0f, depth, true)
                })
            }
            STRUCT => loop {
                let head = self.byte()?;
                if head == 0 {
                    return Some(());
                }
                if head >> 4 == 0 {
                    self.number()?;
                }
                self.skip(head & 0x0f, depth, false)?;
            },
            _ => None,
        }
    }
}

/// Whether a field's kind is that of whole numbers.
pub(crate) fn is_number(kind: u8) -> bool {
    matches!(kind, I16 | I32 | I64)
}

pub(crate) fn is_struct(kind: u8) -> bool {
    kind == STRUCT
}

pub(crate) fn is_list(kind: u8) -> bool {
    kind == LIST
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_heads_are_those_of_the_specification() {
        // Zigzag: 0, -1, 1, -2, 300 (the protocol's own example is 50399 as a varint: df 89 03).
        for (bytes, value) in [
            (&[0][..], 0),
            (&[1], -1),
            (&[2], 1),
            (&[3], -2),
            (&[0xd8, 0x04], 300),
            (&[0xdf, 0x89, 0x03], -25_200),
        ] {
            assert_eq!(Thrift::new(bytes).number(), Some(value), "{bytes:x?}");
        }
        assert_eq!(Thrift::new(&[0x35, 2, 4, 6]).list(), Some((3, I32)));
        assert_eq!(Thrift::new(&[0xf5, 3, 2, 4, 6]).list(), Some((3, I32)));
        // More elements than bytes.
        assert_eq!(Thrift::new(&[0xf5, 0xff, 0xff, 0xff, 0x7f, 0]).list(), None);
        assert_eq!(Thrift::new(&[0xff; 20]).number(), None);
    }

    #[test]
    fn fields_that_nobody_asks_for_are_passed_over() {
        // 1: i32 7; 2: "ab"; 3: list of 2 structs {1: true}, {}; 20: i64 -1; end; a byte behind it.
        let bytes = [0x15, 14, 0x18, 2, b'a', b'b', 0x19, 0x2c, 0x11, 0, 0, 0x06, 40, 1, 0, 99];
        let mut thrift = Thrift::new(&bytes);
        let mut seen = Vec::new();
        thrift
            .fields(|t, number, kind| {
                if !is_number(kind) {
                    return Some(false);
                }
                seen.push((number, t.number()?));
                Some(true)
            })
            .unwrap();
        assert_eq!(seen, [(1, 7), (20, -1)]);
        assert_eq!(thrift.position(), bytes.len() - 1);
    }

    #[test]
    fn structs_without_end_are_refused() {
        assert_eq!(Thrift::new(&[0x1c; 1 << 20]).fields(|_, _, _| Some(false)), None);
        assert_eq!(Thrift::new(&[0x19; 1 << 20]).fields(|_, _, _| Some(false)), None);
    }
}
