//! Collision shapes as convex point clouds.

use crate::ImportError;
use crate::place::{add, dot, scale};
use std::path::Path;
use vb_vehicle::Point;

/// The most that is read of a mesh, bytes.
const MESH: u64 = 64 << 20;
/// The most corners of a mesh.
const CORNERS: usize = 2_000_000;
/// The most groups of a mesh; more become one part.
const GROUPS: usize = 32;
/// Directions in which the outermost points of a mesh are taken.
const DIRECTIONS: u32 = 96;

/// The corners of a block about the origin.
pub(crate) fn block(size: Point) -> Vec<Point> {
    let mut out = Vec::with_capacity(8);
    for z in [-0.5, 0.5] {
        for y in [-0.5, 0.5] {
            for x in [-0.5, 0.5] {
                out.push([x * size[0], y * size[1], z * size[2]]);
            }
        }
    }
    out
}

/// Points of a ball about the origin.
pub(crate) fn ball(radius: f64) -> Vec<Point> {
    directions(32).map(|d| scale(d, radius)).collect()
}

/// Points of a cylinder about the origin, with its axis along a unit vector.
pub(crate) fn barrel(axis: Point, radius: f64, length: f64) -> Vec<Point> {
    let other = if axis[0].abs() < 0.9 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let across = cross(axis, other);
    let u = scale(across, 1.0 / dot(across, across).sqrt());
    let v = cross(axis, u);
    let mut out = Vec::with_capacity(24);
    for end in [-0.5, 0.5] {
        for k in 0..12 {
            let (s, c) = vb_math::sin_cos(std::f64::consts::TAU * f64::from(k) / 12.0);
            let rim = add(scale(u, radius * c), scale(v, radius * s));
            out.push(add(scale(axis, end * length), rim));
        }
    }
    out
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Directions spread evenly over the sphere (Fibonacci's spiral).
fn directions(n: u32) -> impl Iterator<Item = Point> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..n).map(move |k| {
        let z = 1.0 - 2.0 * (f64::from(k) + 0.5) / f64::from(n);
        let (s, c) = vb_math::sin_cos(golden * f64::from(k));
        let r = (1.0 - z * z).sqrt();
        [r * c, r * s, z]
    })
}

/// The outermost points of a cloud: what its convex hull is within some percent of.
pub(crate) fn outermost(points: &[Point]) -> Vec<Point> {
    let axes =
        (0..3).flat_map(|k| [1.0, -1.0].map(|s| std::array::from_fn(|i| if i == k { s } else { 0.0 })));
    let mut chosen: Vec<usize> = directions(DIRECTIONS)
        .chain(axes)
        .filter_map(|d| (0..points.len()).max_by(|a, b| dot(points[*a], d).total_cmp(&dot(points[*b], d))))
        .collect();
    chosen.sort_unstable();
    chosen.dedup();
    chosen.into_iter().map(|k| points[k]).collect()
}

/// The parts of a mesh (.obj or .stl) as convex point clouds.
pub(crate) fn mesh(path: &Path) -> Result<Vec<Vec<Point>>, ImportError> {
    let fail = |problem: String| Err(ImportError::new(path.display(), "", problem));
    let bytes = vb_files::read(path, MESH).map_err(|e| ImportError::reading(path, &e))?;
    let suffix = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let groups = match suffix.as_str() {
        "obj" => obj(&String::from_utf8_lossy(&bytes)),
        "stl" => vec![stl(&bytes)],
        other => {
            return fail(format!("meshes of type {other:?} are not supported; convert it to .obj or .stl"));
        }
    };
    let corners: usize = groups.iter().map(Vec::len).sum();
    if corners > CORNERS {
        return fail(format!(
            "{corners} corners; at most {CORNERS} are allowed (give a coarse collision mesh)"
        ));
    }
    let groups: Vec<Vec<Point>> = if groups.len() > GROUPS { vec![groups.concat()] } else { groups };
    let parts: Vec<Vec<Point>> = groups.iter().map(|g| outermost(g)).filter(|p| solid(p)).collect();
    if parts.is_empty() {
        return fail("no group of its points encloses a volume; give a mesh with faces".to_owned());
    }
    Ok(parts)
}

/// Whether points span a volume.
pub(crate) fn solid(points: &[Point]) -> bool {
    let extent = |k: usize| {
        let (low, high) =
            points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p[k]), b.max(p[k])));
        high - low
    };
    points.len() > 3 && (0..3).all(|k| extent(k) > 1e-4)
}

/// The corners of each group of a Wavefront file.
fn obj(text: &str) -> Vec<Vec<Point>> {
    let (mut corners, mut groups): (Vec<Point>, Vec<Vec<Point>>) = (Vec::new(), vec![Vec::new()]);
    for line in text.lines().take(4 * CORNERS) {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let p: Vec<f64> =
                    words.take(3).filter_map(|w| w.parse().ok()).filter(|x: &f64| x.is_finite()).collect();
                corners.push(<[f64; 3]>::try_from(p).unwrap_or([0.0; 3]));
            }
            Some("o" | "g") => groups.push(Vec::new()),
            Some("f") => {
                let group = groups.len() - 1;
                for word in words {
                    let index = word.split('/').next().and_then(|w| w.parse::<i64>().ok()).unwrap_or(0);
                    let count = i64::try_from(corners.len()).unwrap_or(0);
                    let at = if index < 0 { count + index } else { index - 1 };
                    if let Some(p) = usize::try_from(at).ok().and_then(|k| corners.get(k)) {
                        groups[group].push(*p);
                    }
                }
            }
            _ => {}
        }
    }
    groups.retain(|g| !g.is_empty());
    groups
}

/// The corners of an STL file, binary or text.
fn stl(bytes: &[u8]) -> Vec<Point> {
    let count = bytes.get(80..84).map_or(0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    if count > 0 && bytes.len() == 84 + 50 * count {
        let number = |at: usize| {
            let b = &bytes[at..at + 4];
            f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        };
        let corner = |face: usize, k: usize| {
            let at = 84 + 50 * face + 12 * (k + 1);
            [number(at), number(at + 4), number(at + 8)]
        };
        let all = (0..count.min(CORNERS)).flat_map(|f| (0..3).map(move |k| (f, k)));
        return all.map(|(f, k)| corner(f, k)).filter(|p| p.iter().all(|x| x.is_finite())).collect();
    }
    let text = String::from_utf8_lossy(bytes);
    let vertices = text.lines().filter_map(|l| l.trim().strip_prefix("vertex "));
    vertices
        .filter_map(|l| {
            let p: Vec<f64> =
                l.split_whitespace().filter_map(|w| w.parse().ok()).filter(|x: &f64| x.is_finite()).collect();
            <[f64; 3]>::try_from(p).ok()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_outermost_points_of_a_filled_block_are_its_corners() {
        let mut cloud = block([2.0, 1.0, 0.5]);
        cloud.extend(block([1.0, 0.5, 0.2]));
        let mut hull = outermost(&cloud);
        hull.sort_by(|a, b| a.partial_cmp(b).unwrap());
        let mut corners = block([2.0, 1.0, 0.5]);
        corners.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(hull, corners);
    }

    #[test]
    fn groups_of_a_wavefront_file_are_parts() {
        let mut text = String::new();
        for (group, x) in [("a", 0.0), ("b", 5.0)] {
            text += &format!("g {group}\n");
            for p in block([1.0, 1.0, 1.0]) {
                text += &format!("v {} {} {}\n", p[0] + x, p[1], p[2]);
            }
            text += "f -8 -7 -6\nf -5/1/1 -4 -3\nf -2 -1 -8\n";
        }
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("m.obj");
        std::fs::write(&file, &text).unwrap();
        assert_eq!(mesh(&file).unwrap().len(), 2);
        std::fs::write(&file, "v 0 0 0\nv 1 0 0\nf 1 2\n").unwrap();
        assert!(mesh(&file).unwrap_err().to_string().contains("encloses a volume"));
        let other = dir.path().join("m.dae");
        std::fs::write(&other, "x").unwrap();
        assert!(mesh(&other).unwrap_err().to_string().contains("convert it to .obj or .stl"));
    }
}
