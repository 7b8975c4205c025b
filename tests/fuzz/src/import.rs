//! The original's data as somebody else may have altered them. The seeds are our own, in its formats.

use std::fmt::Write as _;
use std::path::PathBuf;

use vb_suite::import::{Ground, Source};

use crate::site::Site;

/// Pixels along a side.
const SIDE: usize = 33;
/// Patches along a side.
const PATCHES: usize = 4;

/// Whether a patch is of dirt, rock or sand. Sand fills a rectangle, as ground as-simulated wants it in a mixed world.
fn ground(patch: usize) -> usize {
    if patch < PATCHES { 2 } else { patch % 2 }
}

fn config() -> String {
    let mut text = format!(
        "obstacle_density: sparse\nobstacles:\n  rocks:\n  - position: {{x: 3.0, y: 7.0, z: 4.0}}\n    scale: 0.9\n  \
         trees:\n  - position: {{x: -9.0, y: -8.0, z: 2.0}}\npositions:\n- goal: [-12.0, 0.0, 1.0]\n  start: [12.0, 0.0, \
         1.0]\nterrain: {{difficulty: low, is_flat: false, length: {half}, max_height: 8.0, min_height: 0.0, width: \
         {half}}}\nterrain_type: mixed\ntextures:\n",
        half = SIDE as f64 / 2.0
    );
    for k in 0..PATCHES * PATCHES {
        let (i, j) = (k / PATCHES, k % PATCHES);
        let texture = match ground(k) {
            0 => "friction: 0.5\n  is_deformable: false\n  terrain_type: dirt",
            1 => "friction: 0.8\n  is_deformable: false\n  terrain_type: rock",
            _ => "is_deformable: true\n  terrain_type: sand",
        };
        let _ = writeln!(text, "- index: [{i}, {j}]\n  {texture}");
    }
    text
}

/// An 8-bit bitmap with a grey palette, bottom row first.
fn bitmap() -> Vec<u8> {
    let stride = SIDE.next_multiple_of(4);
    let offset = 54 + 4 * 256;
    let mut bytes = b"BM".to_vec();
    let int = |n: usize| u32::try_from(n).expect("a small number").to_le_bytes();
    bytes.extend(int(offset + stride * SIDE));
    bytes.extend([0; 4]);
    bytes.extend(int(offset));
    bytes.extend(int(40));
    bytes.extend(int(SIDE));
    bytes.extend(int(SIDE));
    bytes.extend([1, 0, 8, 0]);
    bytes.extend([0; 8]);
    bytes.extend([0; 8]);
    bytes.extend(int(256));
    bytes.extend(int(0));
    bytes.extend((0..=255u8).flat_map(|g| [g, g, g, 0]));
    for row in 0..SIDE {
        bytes.extend((0..stride).map(|col| ((row * 3 + col * 2) % 256) as u8));
    }
    bytes
}

/// The labels that agree with [`config`].
fn labels() -> Vec<u8> {
    let mut header = format!("{{'descr': '<i4', 'fortran_order': False, 'shape': ({SIDE}, {SIDE}), }}");
    while (header.len() + 11) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\0".to_vec();
    bytes.extend(u16::try_from(header.len()).expect("a short header").to_le_bytes());
    bytes.extend(header.as_bytes());
    let patch = |pixel: usize| (pixel / ((SIDE - 1) / PATCHES)).min(PATCHES - 1);
    for row in 0..SIDE {
        for col in 0..SIDE {
            let label = [2i32, 5, 8][ground(patch(row) * PATCHES + patch(col))];
            bytes.extend(label.to_le_bytes());
        }
    }
    bytes
}

fn site() -> Site {
    let file = |name: &str| PathBuf::from("sampled_maps").join(name);
    Site::new().with(vec![
        (file("Configs/Final/config1_low.yaml"), config().into_bytes()),
        (file("Worlds/1.bmp"), bitmap()),
        (file("Configs/Final/labels1_low.npy"), labels()),
    ])
}

pub(crate) fn run(data: &[u8]) {
    thread_local!(static SITE: Site = site());
    SITE.with(|site| {
        site.replacing(data, |dir| {
            let Ok(source) = Source::find(dir) else { return };
            for ground in Ground::ALL {
                let _ = source.clone().ground(ground).world(1);
            }
        });
    });
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    site().seeds()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A seed that is refused at the door tests nothing behind it.
    #[test]
    fn the_seed_is_a_world_that_is_imported() {
        let site = site();
        for ground in Ground::ALL {
            let world = Source::find(site.path()).and_then(|s| s.ground(ground).world(1)).expect("a world");
            assert_eq!((world.tasks.len(), world.obstacles.len()), (1, 2));
        }
    }
}
