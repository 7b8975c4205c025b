//! Writes the survey of an invented place, the input of examples/site: heights as GeoTIFF, and labels of the ground.
//!
//! `cargo run -p vb-terrain --example synthetic-site -- DIR`

#![allow(clippy::expect_used, reason = "a tool for developers")]

use std::f64::consts::TAU;
use std::fs::File;
use std::io::BufWriter;
use std::path::PathBuf;

use tiff::encoder::{Compression, DeflateLevel, TiffEncoder, colortype};
use tiff::tags::Tag;
use vb_math::{cos, exp, rng::Stream, sin};

/// Samples along x and y, and their distance, m.
const COLS: usize = 150;
const ROWS: usize = 130;
const RESOLUTION: f64 = 2.0;
/// Where the north-western corner lies in a made-up grid of UTM zone 33 north, m.
const CORNER: [f64; 2] = [500_000.0, 5_400_000.0];

fn main() {
    let dir = PathBuf::from(std::env::args_os().nth(1).expect("give a folder"));
    let (mut heights, mut labels) = (Vec::new(), Vec::new());
    let mut noise = Stream::new(1, &["synthetic-site"]);
    let waves: Vec<[f64; 4]> = (0..24)
        .map(|_| {
            let length = noise.uniform(8.0, 60.0);
            let (direction, phase) = (noise.uniform(0.0, TAU), noise.uniform(0.0, TAU));
            [cos(direction) / length, sin(direction) / length, phase, 0.004 * length]
        })
        .collect();
    for row in 0..ROWS {
        for col in 0..COLS {
            let x = (col as f64 - 0.5 * (COLS - 1) as f64) * RESOLUTION;
            let y = (0.5 * (ROWS - 1) as f64 - row as f64) * RESOLUTION;
            // A valley with a stream, a hill with a scarp in the north-east, and undulations.
            let stream = y - 20.0 * sin(x / 45.0);
            let hill = 9.0 * exp(-((x - 80.0) * (x - 80.0) + (y - 70.0) * (y - 70.0)) / 1800.0);
            let scarp = if x > 60.0 && y > 58.0 && y < 61.0 { 1.5 } else { 0.0 };
            let rough: f64 = waves.iter().map(|[kx, ky, p, a]| a * sin(TAU * (kx * x + ky * y) + p)).sum();
            let z = 412.0 + 0.04 * stream.abs() + hill + scarp + rough - 1.2 * exp(-stream * stream / 30.0);
            // Whole centimetres.
            heights.push(((z * 100.0).round() / 100.0) as f32);
            labels.push(match stream.abs() {
                d if d < 6.0 => 3u8,
                d if d < 14.0 => 2,
                _ if hill > 5.0 => 4,
                _ => 1,
            });
        }
    }
    let file = BufWriter::new(File::create(dir.join("heights.tif")).expect("can be written"));
    let mut tiff =
        TiffEncoder::new(file).expect("a TIFF").with_compression(Compression::Deflate(DeflateLevel::Best));
    let mut image = tiff.new_image::<colortype::Gray32Float>(COLS as u32, ROWS as u32).expect("an image");
    let tags = image.encoder();
    // GeoTIFF 1.1: pixel scale, tie point, and the keys for a projected system (EPSG 32633) of pixels that are areas.
    tags.write_tag(Tag::ModelPixelScaleTag, &[RESOLUTION, RESOLUTION, 0.0][..]).expect("a tag");
    let tie = [0.0, 0.0, 0.0, CORNER[0], CORNER[1], 0.0];
    tags.write_tag(Tag::ModelTiepointTag, &tie[..]).expect("a tag");
    let keys: [u16; 16] = [1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32633];
    tags.write_tag(Tag::GeoKeyDirectoryTag, &keys[..]).expect("a tag");
    image.write_data(&heights).expect("can be written");
    let file = BufWriter::new(File::create(dir.join("labels.png")).expect("can be written"));
    let mut png = png::Encoder::new(file, COLS as u32, ROWS as u32);
    png.set_color(png::ColorType::Grayscale);
    png.set_depth(png::BitDepth::Eight);
    png.write_header().and_then(|mut writer| writer.write_image_data(&labels)).expect("can be written");
}
