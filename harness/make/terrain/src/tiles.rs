//! Square tiles cut from elevation data.

use std::collections::BTreeSet;

use vb_files::Hash;
use vb_math::rng::Stream;

use crate::data::{Layer, Scan};

/// How tiles are cut.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// Samples along a side.
    pub side: usize,
    /// Samples from one tile to the next.
    pub stride: usize,
    /// Largest share of a tile that need not be measured.
    pub holes: f64,
}

/// The place of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Place {
    scan: usize,
    layer: usize,
    row: usize,
    col: usize,
}

/// Tiles of scans. A tile that is another's copy, turned or mirrored or not, counts once.
#[derive(Clone, Debug)]
pub struct Tiles<'a> {
    scans: Vec<&'a Scan>,
    cut: Cut,
    places: Vec<Place>,
    copies: usize,
}

/// A tile's heights and which of them were measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    /// Row-major heights.
    pub heights: Vec<f64>,
    /// Which of them are measurements.
    pub measured: Vec<bool>,
}

impl<'a> Tiles<'a> {
    pub fn cut(scans: impl IntoIterator<Item = &'a Scan>, cut: Cut) -> Self {
        let scans: Vec<&Scan> = scans.into_iter().collect();
        let mut tiles = Self { scans, cut, places: Vec::new(), copies: 0 };
        let mut seen = BTreeSet::new();
        let mut places = Vec::new();
        for (s, scan) in tiles.scans.iter().enumerate() {
            for (l, layer) in scan.layers.iter().enumerate() {
                let steps = |n: usize| (0..=n.saturating_sub(cut.side)).step_by(cut.stride.max(1));
                let (rows, cols) = (layer.heights.rows(), layer.heights.cols());
                if rows < cut.side || cols < cut.side {
                    continue;
                }
                for row in steps(rows) {
                    for col in steps(cols) {
                        let place = Place { scan: s, layer: l, row, col };
                        let tile = tiles.at(place);
                        let holes = tile.measured.iter().filter(|m| !**m).count();
                        if holes as f64 > cut.holes * tile.measured.len() as f64 {
                            continue;
                        }
                        if seen.insert(fingerprint(&tile, cut.side)) {
                            places.push(place);
                        } else {
                            tiles.copies += 1;
                        }
                    }
                }
            }
        }
        tiles.places = places;
        tiles
    }

    /// Number of different tiles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.places.len()
    }

    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Number of tiles that were left out as copies of others.
    #[must_use]
    pub fn copies(&self) -> usize {
        self.copies
    }

    /// A tile as it was cut.
    #[must_use]
    pub fn get(&self, index: usize) -> Tile {
        self.at(self.places[index])
    }

    /// A random tile, moved by less than a stride where its scan goes on, in one of the eight symmetries of the square.
    #[must_use]
    pub fn draw(&self, rng: &mut Stream) -> Tile {
        let mut place = self.places[rng.below(self.places.len() as u64) as usize];
        let layer = self.layer(place);
        let stride = self.cut.stride.max(1);
        let mut moved = |at: usize, end: usize| {
            let room = (end - self.cut.side - at).min(stride - 1);
            at + rng.below(room as u64 + 1) as usize
        };
        place.row = moved(place.row, layer.heights.rows());
        place.col = moved(place.col, layer.heights.cols());
        let symmetry = rng.below(8) as usize;
        self.at(place).turned(self.cut.side, symmetry)
    }

    fn layer(&self, place: Place) -> &Layer {
        &self.scans[place.scan].layers[place.layer]
    }

    fn at(&self, place: Place) -> Tile {
        let layer = self.layer(place);
        let (side, cols) = (self.cut.side, layer.heights.cols());
        let mut tile = Tile { heights: Vec::with_capacity(side * side), measured: Vec::new() };
        for row in place.row..place.row + side {
            let line = row * cols + place.col..row * cols + place.col + side;
            tile.heights.extend_from_slice(&layer.heights.values()[line.clone()]);
            tile.measured.extend_from_slice(&layer.measured[line]);
        }
        tile
    }
}

impl Tile {
    /// The tile in one of the eight symmetries of the square: bit 0 mirrors columns, bit 1 rows, bit 2 exchanges the two.
    #[must_use]
    pub fn turned(&self, side: usize, symmetry: usize) -> Self {
        let from = |i: usize| source(i, side, symmetry);
        Self {
            heights: (0..side * side).map(|i| self.heights[from(i)]).collect(),
            measured: (0..side * side).map(|i| self.measured[from(i)]).collect(),
        }
    }
}

/// Where sample `i` of a turned tile comes from.
fn source(i: usize, side: usize, symmetry: usize) -> usize {
    let (mut r, mut c) = (i / side, i % side);
    if symmetry & 1 != 0 {
        c = side - 1 - c;
    }
    if symmetry & 2 != 0 {
        r = side - 1 - r;
    }
    if symmetry & 4 != 0 {
        (r, c) = (c, r);
    }
    r * side + c
}

/// The same for a tile and all its turned and mirrored copies.
fn fingerprint(tile: &Tile, side: usize) -> String {
    let hash = |symmetry: usize| -> String {
        let mut h = Hash::new();
        for i in 0..side * side {
            h.update(tile.heights[source(i, side, symmetry)].to_bits().to_le_bytes());
        }
        h.hex()
    };
    (0..8).map(hash).min().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ElevationImage;
    use crate::repair::Repaired;

    fn scan(rows: usize, cols: usize, z: impl Fn(usize, usize) -> f64) -> Scan {
        let heights =
            ElevationImage::new(rows, cols, (0..rows * cols).map(|i| z(i / cols, i % cols)).collect());
        let layer = Layer { heights, measured: vec![true; rows * cols] };
        Scan { name: "a".into(), held_out: false, repaired: Repaired::default(), layers: vec![layer] }
    }

    #[test]
    fn a_mosaic_of_turned_copies_holds_one_tile() {
        // The original's training images: 4 × 4 copies of one tile, mirrored at will (its envs/data/elev_maps).
        let tile = |r: usize, c: usize| ((r * 13 + c * 7 + r * r * c) % 31) as f64;
        let mirrored = |r: usize, c: usize| {
            let (block, r, c) = (r / 8 * 4 + c / 8, r % 8, c % 8);
            tile(if block % 3 == 0 { 7 - r } else { r }, if block % 2 == 0 { 7 - c } else { c })
        };
        let scan = scan(32, 32, mirrored);
        let tiles = Tiles::cut([&scan], Cut { side: 8, stride: 8, holes: 0.0 });
        assert_eq!((tiles.len(), tiles.copies()), (1, 15));
    }

    #[test]
    fn the_symmetries_are_the_eight_of_the_square() {
        let tile = Tile { heights: (0..9).map(f64::from).collect(), measured: vec![true; 9] };
        let all: BTreeSet<Vec<u64>> =
            (0..8).map(|s| tile.turned(3, s).heights.iter().map(|v| v.to_bits()).collect()).collect();
        assert_eq!(all.len(), 8);
        // Each keeps the centre and which samples are next to each other.
        for s in 0..8 {
            let t = tile.turned(3, s).heights;
            assert_eq!(t[4], 4.0);
            assert!([1.0, 3.0].contains(&(t[0] - t[1]).abs()));
        }
    }

    #[test]
    fn tiles_with_too_many_holes_are_left_out() {
        let mut s = scan(8, 16, |r, c| (r * 16 + c) as f64);
        for i in 0..5 {
            s.layers[0].measured[i] = false;
        }
        let of = |holes| Tiles::cut([&s], Cut { side: 8, stride: 8, holes }).len();
        assert_eq!((of(0.0), of(4.0 / 64.0), of(5.0 / 64.0)), (1, 1, 2));
    }

    #[test]
    fn draws_stay_within_the_scan_and_depend_on_the_stream_alone() {
        let s = scan(11, 19, |r, c| (r * 19 + c) as f64);
        let tiles = Tiles::cut([&s], Cut { side: 8, stride: 4, holes: 0.0 });
        assert_eq!(tiles.len(), 3);
        let mut a = Stream::new(1, &["draw"]);
        let mut b = a.clone();
        let mut corners = BTreeSet::new();
        for _ in 0..200 {
            let t = tiles.draw(&mut a);
            assert_eq!(t, tiles.draw(&mut b));
            corners.insert(t.heights.iter().fold(f64::INFINITY, |m, v| m.min(*v)) as u32);
        }
        // Three places down, eleven along (the last tile begins at column 8 and has three to spare).
        assert_eq!(corners.len(), 4 * 12);
    }
}
