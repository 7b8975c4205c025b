//! Parquet files of strangers, read within bounds.
//!
//! A few bytes of such a file can stand for any amount of memory: runs of a dictionary's values, pages that are said to be large,
//! schemas within schemas, columns that all lie in the same bytes. The decoder trusts what pages say of themselves, so all that is
//! multiplied there is summed here before, without decoding anything.
//!
//! Source: Apache Parquet, `parquet.thrift` (`FileMetaData`, `SchemaElement`, `PageHeader`).

use std::io;
use std::path::Path;

use bytes::Bytes;
use parquet::basic::Compression;
use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaData, ParquetMetaDataReader};

use vb_files::decoding;

use crate::thrift::{Thrift, is_list, is_number, is_struct};

/// The most that a Parquet file may have.
#[derive(Clone, Copy, Debug)]
pub struct ParquetBounds {
    /// The size of the file, bytes.
    pub file: u64,
    /// The values of all columns together.
    pub values: u64,
    /// The bytes of all pages together after decompression.
    pub bytes: u64,
    /// The bytes of a dictionary after decompression: each of its entries can stand in every row.
    pub dictionary: u64,
}

/// Length of the footer at most, bytes. Ours have some kilobytes.
const FOOTER: usize = 8 << 20;
/// Elements of the schema at most.
const ELEMENTS: usize = 4096;
/// Groups within each other in the schema at most; grids of datasets have six.
const DEPTH: usize = 16;
/// Row groups at most.
const ROW_GROUPS: usize = 1 << 16;
/// Pages at most.
const PAGES: u64 = 1 << 20;
/// Length of a page's header at most, bytes; statistics make up most of it.
const HEADER: usize = 64 << 10;
/// Snappy makes at most 64 bytes of a copy, which takes 3 (google/snappy, `format_description.txt`); some bytes for short pages.
const SNAPPY: (u64, u64) = (22, 64);
/// Encodings in which every value takes up what it takes up, or is an entry of a dictionary: PLAIN, PLAIN_DICTIONARY, RLE,
/// BIT_PACKED, RLE_DICTIONARY and BYTE_STREAM_SPLIT. The others are deltas, in which a few bytes are a long text.
const ENCODINGS: [i64; 6] = [0, 2, 3, 4, 8, 9];

/// The problem of a file, in words.
pub(crate) type Problem = String;

/// The content of a Parquet file that is within `bounds`.
///
/// # Errors
/// Returns an error of the operating system, of kind [`io::ErrorKind::InvalidData`] if the file is beyond the bounds, truncated or no
/// Parquet file; it says what is wrong.
pub fn read_parquet(path: &Path, bounds: &ParquetBounds) -> io::Result<Bytes> {
    let bytes = Bytes::from(vb_files::read(path, bounds.file)?);
    let checked = decoding(|| check(&bytes, bounds)).flatten();
    checked.map_err(|problem| io::Error::new(io::ErrorKind::InvalidData, problem))?;
    Ok(bytes)
}

/// Whether a file is within bounds.
pub(crate) fn check(bytes: &Bytes, bounds: &ParquetBounds) -> Result<(), Problem> {
    check_footer(footer(bytes)?)?;
    let mut reader = ParquetMetaDataReader::new();
    reader.try_parse(bytes).map_err(|e| e.to_string())?;
    let metadata = reader.finish().map_err(|e| e.to_string())?;
    check_pages(bytes, &metadata, bounds)
}

/// The part of the file that says what is in it.
fn footer(bytes: &Bytes) -> Result<&[u8], Problem> {
    let (rest, end) = bytes.split_last_chunk::<8>().ok_or("the file is too short to be a Parquet file")?;
    let [a, b, c, d, mark @ ..] = end;
    if mark != b"PAR1" || !bytes.starts_with(b"PAR1") {
        return Err("it is not a Parquet file, or is truncated".into());
    }
    let length = u32::from_le_bytes([*a, *b, *c, *d]) as usize;
    if length > FOOTER {
        return Err(format!("its footer has {length} bytes; at most {FOOTER} are allowed"));
    }
    let start = rest.len().checked_sub(length).ok_or("its footer is longer than the file")?;
    Ok(&rest[start..])
}

/// Bounds what the decoder of the footer builds of it: a tree by recursion, and lists.
fn check_footer(footer: &[u8]) -> Result<(), Problem> {
    let mut problem = None;
    let mut children = Vec::new();
    let read = Thrift::new(footer).fields(|footer, number, kind| {
        let most = match number {
            2 => ELEMENTS,
            4 => ROW_GROUPS,
            _ => return Some(false),
        };
        if !is_list(kind) {
            return None;
        }
        // Row groups are only counted, so their list is read by a copy.
        let mut list = footer.clone();
        let (count, element) = list.list()?;
        if count > most {
            let what = if number == 2 { "elements in its schema" } else { "row groups" };
            problem = Some(format!("it has {count} {what}; at most {most} are allowed"));
            return None;
        }
        if number == 4 {
            return Some(false);
        }
        if !is_struct(element) {
            return None;
        }
        children.clear();
        for _ in 0..count {
            let mut own = 0;
            list.fields(|element, number, kind| {
                if number != 5 || !is_number(kind) {
                    return Some(false);
                }
                own = element.number()?;
                Some(true)
            })?;
            children.push(own);
        }
        *footer = list;
        Some(true)
    });
    match (problem, read) {
        (Some(problem), _) => Err(problem),
        (None, None) => Err("its footer is damaged".into()),
        (None, Some(())) => check_schema(&children),
    }
}

/// Checks the tree of a schema, of which the number of children of each element is given in the order of the file.
fn check_schema(children: &[i64]) -> Result<(), Problem> {
    // Children that are still to come, of each open group.
    let mut open: Vec<i64> = Vec::new();
    for (k, own) in children.iter().enumerate() {
        let left = children.len() - k - 1;
        if usize::try_from(*own).is_ok_and(|own| own <= left) {
            if *own > 0 {
                open.push(*own);
            }
        } else {
            return Err(format!(
                "element {k} of its schema has {own} children, but only {left} elements follow"
            ));
        }
        if open.len() > DEPTH {
            return Err(format!("its schema has more than {DEPTH} nested groups"));
        }
        // This element is a child of the innermost group, unless it has opened one.
        if *own == 0 {
            while let Some(last) = open.last_mut() {
                *last -= 1;
                if *last > 0 {
                    break;
                }
                open.pop();
            }
        }
    }
    Ok(())
}

/// Sums over pages.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    pages: u64,
    values: u64,
    bytes: u64,
}

fn check_pages(bytes: &Bytes, metadata: &ParquetMetaData, bounds: &ParquetBounds) -> Result<(), Problem> {
    let mut sums = Sums::default();
    for (k, group) in metadata.row_groups().iter().enumerate() {
        // A column without pages, or no column at all, has no rows either, whatever is said.
        let rows = u64::try_from(group.num_rows()).unwrap_or(u64::MAX);
        if rows > bounds.values {
            return Err(format!(
                "row group {k} has {} rows; at most {} are allowed",
                group.num_rows(),
                bounds.values
            ));
        }
        for column in group.columns() {
            check_column(bytes, column, bounds, &mut sums)
                .map_err(|problem| format!("column {}: {problem}", column.column_path().string()))?;
        }
    }
    Ok(())
}

/// The pages of a column: those that its decoder will find, one behind the other.
fn check_column(
    bytes: &Bytes,
    column: &ColumnChunkMetaData,
    bounds: &ParquetBounds,
    sums: &mut Sums,
) -> Result<(), Problem> {
    let start = column.dictionary_page_offset().unwrap_or_else(|| column.data_page_offset());
    let range = usize::try_from(start).ok().zip(usize::try_from(column.compressed_size()).ok());
    let within = range.and_then(|(start, length)| bytes.get(start..start.checked_add(length)?));
    let mut rest = within.ok_or("its pages are not within the file")?;
    while !rest.is_empty() {
        let (page, length) = Page::read(rest).ok_or("the header of a page is damaged")?;
        rest = usize::try_from(page.compressed)
            .ok()
            .and_then(|size| rest.get(length.checked_add(size)?..))
            .ok_or("a page is longer than its column")?;
        let (compressed, size) = (page.compressed, page.uncompressed.max(page.compressed));
        if column.compression() == Compression::SNAPPY && page.uncompressed > compressed * SNAPPY.0 + SNAPPY.1
        {
            return Err(format!("a page of {compressed} bytes cannot decompress to {}", page.uncompressed));
        }
        if !page.encodings.iter().flatten().all(|encoding| ENCODINGS.contains(encoding)) {
            return Err("delta encoding is not supported: write it PLAIN or with a dictionary".into());
        }
        if page.is_dictionary && (size > bounds.dictionary || page.values > size) {
            return Err(format!(
                "a dictionary of {} values in {size} bytes; at most {} bytes are allowed",
                page.values, bounds.dictionary
            ));
        }
        sums.pages += 1;
        if !page.is_dictionary {
            sums.values = sums.values.saturating_add(page.values);
        }
        sums.bytes = sums.bytes.saturating_add(size);
        for (what, sum, most) in [
            ("pages", sums.pages, PAGES),
            ("values", sums.values, bounds.values),
            ("bytes before compression", sums.bytes, bounds.bytes),
        ] {
            if sum > most {
                return Err(format!("the file has more than {most} {what}, the limit for such a file"));
            }
        }
    }
    Ok(())
}

/// What a page says of itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Page {
    uncompressed: u64,
    compressed: u64,
    values: u64,
    is_dictionary: bool,
    /// Of the values and of the levels, where the page has them.
    encodings: [Option<i64>; 3],
}

impl Page {
    /// The page whose header is at the beginning of `bytes`, and the length of the header.
    fn read(bytes: &[u8]) -> Option<(Self, usize)> {
        let mut thrift = Thrift::new(&bytes[..bytes.len().min(HEADER)]);
        let mut page = Self::default();
        let size = |t: &mut Thrift<'_>| u64::try_from(i32::try_from(t.number()?).ok()?).ok();
        thrift.fields(|t, number, kind| match (number, kind) {
            (2, kind) if is_number(kind) => {
                page.uncompressed = size(t)?;
                Some(true)
            }
            (3, kind) if is_number(kind) => {
                page.compressed = size(t)?;
                Some(true)
            }
            // Header of a data page, of a dictionary, and of a data page of version 2.
            (5 | 7 | 8, kind) if is_struct(kind) => {
                page.is_dictionary |= number == 7;
                // Where the encodings of values and levels are.
                let encodings: &[i64] = match number {
                    5 => &[2, 3, 4],
                    7 => &[2],
                    _ => &[4],
                };
                t.fields(|t, field, kind| {
                    if !is_number(kind) {
                        return Some(false);
                    }
                    if field == 1 {
                        page.values = page.values.max(size(t)?);
                    } else if let Some(k) = encodings.iter().position(|e| *e == field) {
                        page.encodings[k] = Some(t.number()?);
                    } else {
                        return Some(false);
                    }
                    Some(true)
                })?;
                Some(true)
            }
            _ => Some(false),
        })?;
        Some((page, thrift.position()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trees_of_a_schema_are_bounded() {
        // A root with two columns, one of which is a list in a group.
        assert_eq!(check_schema(&[2, 0, 1, 1, 0]), Ok(()));
        assert_eq!(check_schema(&[]), Ok(()));
        let chain = |n: usize| (0..n).map(|k| i64::from(k + 1 < n)).collect::<Vec<_>>();
        assert_eq!(check_schema(&chain(DEPTH + 1)), Ok(()));
        assert!(check_schema(&chain(DEPTH + 2)).unwrap_err().contains("nested groups"));
        // Many groups side by side are not deep.
        let flat: Vec<i64> = std::iter::once(1000).chain([1, 0].repeat(1000)).collect();
        assert_eq!(check_schema(&flat), Ok(()));
        for bad in [&[i64::from(i32::MAX), 0][..], &[-1, 0], &[1]] {
            assert!(check_schema(bad).unwrap_err().contains("children"), "{bad:?}");
        }
    }

    #[test]
    fn a_page_is_read_as_the_format_has_it() {
        // DATA_PAGE, 4000 bytes of 100, 1000 values PLAIN, levels RLE; then the header's end and a byte of the page.
        let bytes = [
            0x15, 0, 0x15, 0xc0, 0x3e, 0x15, 0xc8, 0x01, 0x2c, 0x15, 0xd0, 0x0f, 0x15, 0, 0x15, 6, 0x15, 6,
            0, 0, 42,
        ];
        let (page, length) = Page::read(&bytes).unwrap();
        assert_eq!((page.uncompressed, page.compressed, page.values), (4000, 100, 1000));
        assert_eq!((page.is_dictionary, page.encodings), (false, [Some(0), Some(3), Some(3)]));
        assert_eq!(length, bytes.len() - 1);
        // A size below 0.
        assert!(Page::read(&[0x25, 1, 0]).is_none());
        assert!(Page::read(&[0x15; 100_000]).is_none());
    }

    const ENOUGH: ParquetBounds =
        ParquetBounds { file: 1 << 20, values: 1 << 20, bytes: 1 << 20, dictionary: 1 << 20 };

    /// A file of two columns with `rows` rows.
    fn table(rows: usize) -> Bytes {
        use crate::parquet_io::{Column, encode};
        let text = (0..rows).map(|k| parquet::data_type::ByteArray::from(["a", "bc"][k % 2])).collect();
        let columns = vec![
            ("name".to_owned(), Column::Text(text)),
            ("value".to_owned(), Column::F32((0..rows).map(|k| k as f32).collect())),
        ];
        encode("key", "{}".to_owned(), columns).unwrap().into()
    }

    fn refused(bytes: &Bytes, bounds: &ParquetBounds) -> String {
        check(bytes, bounds).unwrap_err()
    }

    #[test]
    fn each_bound_is_held() {
        let file = table(1000);
        assert_eq!(check(&file, &ENOUGH), Ok(()));
        // Two columns of a thousand values, 4000 bytes of them numbers; a dictionary of "a" and "bc" with their lengths is 11 bytes, of
        // which Snappy makes 13.
        assert_eq!(check(&file, &ParquetBounds { values: 2000, dictionary: 13, ..ENOUGH }), Ok(()));
        let e = refused(&file, &ParquetBounds { values: 1999, ..ENOUGH });
        assert!(e.contains("column value: the file has more than 1999 values"), "{e}");
        let e = refused(&file, &ParquetBounds { values: 999, ..ENOUGH });
        assert!(e.contains("row group 0 has 1000 rows; at most 999 are allowed"), "{e}");
        let e = refused(&file, &ParquetBounds { bytes: 4000, ..ENOUGH });
        assert!(e.contains("the file has more than 4000 bytes before compression"), "{e}");
        let e = refused(&file, &ParquetBounds { dictionary: 12, ..ENOUGH });
        assert!(e.contains("column name: a dictionary of 2 values in 13 bytes; at most 12 bytes"), "{e}");
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.parquet");
        std::fs::write(&path, &file).unwrap();
        assert_eq!(read_parquet(&path, &ENOUGH).unwrap(), file);
        let e = read_parquet(&path, &ParquetBounds { file: 100, ..ENOUGH }).unwrap_err();
        assert_eq!(e.kind(), io::ErrorKind::InvalidData, "{e}");
    }

    /// What a file is that has nothing but a footer.
    fn with_footer(footer: &[u8]) -> Bytes {
        let length = u32::try_from(footer.len()).unwrap().to_le_bytes();
        [b"PAR1", footer, &length, b"PAR1"].concat().into()
    }

    /// A footer whose schema has these numbers of children, with as many row groups as said.
    fn footer_of(children: &[i64], groups: usize) -> Vec<u8> {
        fn varint(mut v: u64, to: &mut Vec<u8>) {
            while v >= 0x80 {
                to.push(v as u8 | 0x80);
                v >>= 7;
            }
            to.push(v as u8);
        }
        let zigzag = |v: i64| ((v << 1) ^ (v >> 63)).cast_unsigned();
        // 1: version 1; 2: list of structs.
        let mut footer = vec![0x15, 2, 0x19, 0xfc];
        varint(children.len() as u64, &mut footer);
        for own in children {
            // 3: repeated? no: required; 4: name "a"; 5: number of children.
            footer.extend([0x35, 0, 0x18, 1, b'a', 0x15]);
            varint(zigzag(*own), &mut footer);
            footer.push(0);
        }
        // 3: no rows; 4: list of empty structs.
        footer.extend([0x16, 0, 0x19, 0xfc]);
        varint(groups as u64, &mut footer);
        footer.extend(std::iter::repeat_n(0, groups));
        footer.push(0);
        footer
    }

    #[test]
    fn footers_that_would_be_trees_and_lists_without_end_are_refused() {
        let chain: Vec<i64> = (0..4000).map(|k| i64::from(k < 3999)).collect();
        let e = refused(&with_footer(&footer_of(&chain, 0)), &ENOUGH);
        assert!(e.contains("more than 16 nested groups"), "{e}");
        let e = refused(&with_footer(&footer_of(&[i64::from(i32::MAX), 0], 0)), &ENOUGH);
        assert!(e.contains("2147483647 children, but only 1 elements follow"), "{e}");
        let e = refused(&with_footer(&footer_of(&[0; 5000], 0)), &ENOUGH);
        assert!(e.contains("5000 elements in its schema; at most 4096"), "{e}");
        let e = refused(&with_footer(&footer_of(&[1, 0], 100_000)), &ENOUGH);
        assert!(e.contains("100000 row groups; at most 65536"), "{e}");
        let mut long = table(1).to_vec();
        let at = long.len() - 8;
        long[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(refused(&long.into(), &ENOUGH).contains("its footer has 4294967295 bytes"));
        for odd in [&b""[..], b"PAR1", b"PAR1PAR1", b"PAR1\xff\0\0\0PAR1", b"PAR1\0\0\0\0PARE"] {
            refused(&Bytes::copy_from_slice(odd), &ENOUGH);
        }
    }

    /// Whatever bit of a file is another, it is read within bounds or refused, without a panic.
    #[test]
    fn no_bit_of_a_file_ends_its_reader() {
        use parquet::file::reader::{FileReader as _, SerializedFileReader};
        let whole = table(40);
        for bit in 0..8 * whole.len() {
            let mut bytes = whole.to_vec();
            bytes[bit / 8] ^= 1 << (bit % 8);
            let bytes = Bytes::from(bytes);
            if check(&bytes, &ENOUGH).is_ok() {
                let reader = SerializedFileReader::new(bytes).unwrap();
                let groups = (0..reader.num_row_groups()).filter_map(|g| reader.get_row_group(g).ok());
                for group in groups {
                    for column in 0..group.num_columns() {
                        let Ok(mut pages) = group.get_column_page_reader(column) else { continue };
                        while let Ok(Some(_)) = pages.get_next_page() {}
                    }
                }
            }
        }
    }
}
