//! Heights as worlds keep them.

use vb_world::Heightfield;

/// A square surface of these heights (row 0 in the south), counted from its lowest node. They are rounded to the levels
/// that a suite's elevation image has, so that what is planned and checked is what is read back: to multiples of `step`, m, where that
/// is given and 16 bits reach that far; else to 16 bits over the surface's own range.
pub(crate) fn counted_from_lowest(
    nodes: usize,
    resolution: f64,
    heights: &[f64],
    step: Option<f64>,
) -> Heightfield {
    let most = f64::from(u16::MAX);
    let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // Whole millimetres, which people can read; a range of nothing can't be divided into levels.
    let own = (((high - low) * 1000.0).ceil() / 1000.0).max(1e-3);
    let range = step.map(|s| s * most).filter(|reach| own <= *reach).unwrap_or(own);
    let levels: Vec<u16> = heights.iter().map(|z| ((z - low) / range * most).round() as u16).collect();
    Heightfield::from_levels(nodes, nodes, resolution, [0.0, range], &levels)
}
