//! GeoTIFFs written byte by byte, with whatever tags a test wants.

use std::collections::BTreeMap;

/// A page: its tags, and its strips or tiles as they lie in the file.
#[derive(Clone, Default)]
pub struct Page {
    tags: BTreeMap<u16, Value>,
    chunks: Vec<Vec<u8>>,
    tiled: bool,
}

#[derive(Clone)]
pub enum Value {
    Short(Vec<u16>),
    Long(Vec<u32>),
    Double(Vec<f64>),
    Text(String),
}

/// A file of pages.
#[derive(Clone, Default)]
pub struct Tif {
    pub pages: Vec<Page>,
    pub big_endian: bool,
    /// BigTIFF.
    pub long: bool,
}

impl Page {
    /// One band of samples of these bits in one strip.
    pub fn new(cols: u32, rows: u32, bits: u16, format: u16, strip: Vec<u8>) -> Self {
        let page = Self { chunks: vec![strip], ..Self::default() };
        page.long(256, cols)
            .long(257, rows)
            .short(258, &[bits])
            .short(259, &[1])
            .short(262, &[1])
            .short(277, &[1])
            .long(278, rows)
            .short(339, &[format])
    }

    /// Floats of 32 bits, little-endian.
    pub fn floats(cols: u32, values: &[f32]) -> Self {
        let bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        Self::new(cols, values.len() as u32 / cols, 32, 3, bytes)
    }

    pub fn short(mut self, tag: u16, values: &[u16]) -> Self {
        self.tags.insert(tag, Value::Short(values.to_vec()));
        self
    }

    pub fn long(mut self, tag: u16, value: u32) -> Self {
        self.tags.insert(tag, Value::Long(vec![value]));
        self
    }

    pub fn double(mut self, tag: u16, values: &[f64]) -> Self {
        self.tags.insert(tag, Value::Double(values.to_vec()));
        self
    }

    pub fn text(mut self, tag: u16, text: &str) -> Self {
        self.tags.insert(tag, Value::Text(text.to_owned()));
        self
    }

    /// Pixels of this size from a north-western corner.
    pub fn at(self, corner: [f64; 2], size: [f64; 2]) -> Self {
        self.double(33550, &[size[0], size[1], 0.0])
            .double(33922, &[0.0, 0.0, 0.0, corner[0], corner[1], 0.0])
    }

    /// Geographic keys with their values.
    pub fn keys(self, keys: &[[u16; 2]]) -> Self {
        let mut all = vec![1, 1, 0, keys.len() as u16];
        keys.iter().for_each(|[key, value]| all.extend([*key, 0, 1, *value]));
        self.short(34735, &all)
    }

    /// Several strips of some rows, or tiles of a size.
    pub fn chunks(mut self, chunks: Vec<Vec<u8>>, tile: Option<[u32; 2]>, rows_per_strip: u32) -> Self {
        self.chunks = chunks;
        self.tiled = tile.is_some();
        if let Some([width, height]) = tile {
            self.tags.remove(&278);
            return self.long(322, width).long(323, height);
        }
        self.long(278, rows_per_strip)
    }

    pub fn file(self) -> Vec<u8> {
        Tif { pages: vec![self], ..Tif::default() }.bytes()
    }
}

impl Tif {
    pub fn bytes(&self) -> Vec<u8> {
        let number = |v: u64, size: usize| -> Vec<u8> {
            if self.big_endian {
                v.to_be_bytes()[8 - size..].to_vec()
            } else {
                v.to_le_bytes()[..size].to_vec()
            }
        };
        let word = if self.long { 8 } else { 4 };
        let mut out = if self.big_endian { b"MM".to_vec() } else { b"II".to_vec() };
        out.extend(number(if self.long { 43 } else { 42 }, 2));
        if self.long {
            out.extend(number(8, 2));
            out.extend(number(0, 2));
        }
        let mut link = out.len();
        out.extend(number(0, word));
        for page in &self.pages {
            let mut tags = page.tags.clone();
            let mut places = Vec::new();
            for chunk in &page.chunks {
                places.push(out.len() as u32);
                out.extend(chunk);
            }
            let lengths = page.chunks.iter().map(|c| c.len() as u32).collect();
            let (place, length) = if page.tiled { (324, 325) } else { (273, 279) };
            tags.insert(place, Value::Long(places));
            tags.insert(length, Value::Long(lengths));
            let mut entries = Vec::new();
            for (tag, value) in &tags {
                let (kind, count, bytes): (u16, usize, Vec<u8>) = match value {
                    Value::Short(v) => {
                        (3, v.len(), v.iter().flat_map(|v| number(u64::from(*v), 2)).collect())
                    }
                    Value::Long(v) => (4, v.len(), v.iter().flat_map(|v| number(u64::from(*v), 4)).collect()),
                    Value::Double(v) => {
                        (12, v.len(), v.iter().flat_map(|v| number(v.to_bits(), 8)).collect())
                    }
                    Value::Text(t) => (2, t.len() + 1, [t.as_bytes(), &[0]].concat()),
                };
                let mut field = bytes.clone();
                if bytes.len() > word {
                    field = number(out.len() as u64, word);
                    out.extend(bytes);
                }
                field.resize(word, 0);
                entries.push(
                    [
                        number(u64::from(*tag), 2),
                        number(u64::from(kind), 2),
                        number(count as u64, word),
                        field,
                    ]
                    .concat(),
                );
            }
            let here = number(out.len() as u64, word);
            out[link..link + word].copy_from_slice(&here);
            out.extend(number(entries.len() as u64, if self.long { 8 } else { 2 }));
            out.extend(entries.concat());
            link = out.len();
            out.extend(number(0, word));
        }
        out
    }
}
