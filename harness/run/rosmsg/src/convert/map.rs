//! Maps.

use vb_sdk::{GridFrame, HeightMap, LabelMap};

use super::{frame, header};
use crate::messages::geometry_msgs::{Point, Pose, Quaternion};
use crate::messages::grid_map_msgs::{GridMap, GridMapInfo};
use crate::messages::nav_msgs::{MapMetaData, OccupancyGrid};
use crate::messages::std_msgs::{Float32MultiArray, MultiArrayDimension, MultiArrayLayout};

/// The label of a sample that is unknown.
const UNKNOWN: u8 = 255;

fn pose(x: f64, y: f64) -> Pose {
    Pose { position: Point { x, y, z: 0.0 }, orientation: Quaternion { w: 1.0, ..Quaternion::default() } }
}

/// Obstacles as an occupancy grid in `map`: 100 where an obstacle covers any part of a cell, 0 where none does, −1 where that is unknown.
#[must_use]
pub fn occupancy_grid(nanoseconds: i64, map: &LabelMap) -> OccupancyGrid {
    let GridFrame { rows, cols, resolution, origin_x, origin_y } = map.frame;
    let header = header(nanoseconds, frame::MAP);
    OccupancyGrid {
        info: MapMetaData {
            map_load_time: header.stamp.clone(),
            resolution: resolution as f32,
            width: cols,
            height: rows,
            // The corner of the first cell, whose middle is the first sample.
            origin: pose(origin_x - 0.5 * resolution, origin_y - 0.5 * resolution),
        },
        data: map
            .data
            .iter()
            .map(|label| match *label {
                0 => 0,
                UNKNOWN => -1,
                _ => 100,
            })
            .collect(),
        header,
    }
}

/// Heights, m, as the layer `elevation` of a grid map in `map`, and terrain classes as the layer `terrain_class` where they are known on
/// the same grid; NaN where a value is unknown.
///
/// The matrix of a grid map has its first row at the greatest x and its first column at the greatest y, and lies column by column in the
/// message (`grid_map_core`'s `getPositionFromIndex`, `grid_map_ros`'s `matrixEigenCopyToMultiArrayMessage`).
#[must_use]
pub fn elevation_map(nanoseconds: i64, heights: &HeightMap, classes: Option<&LabelMap>) -> GridMap {
    let GridFrame { rows, cols, resolution, origin_x, origin_y } = heights.frame;
    let mut layers = vec!["elevation".to_owned()];
    let mut data = vec![layer(rows, cols, |at| heights.data.get(at).copied().unwrap_or(f32::NAN))];
    if let Some(classes) = classes.filter(|c| c.frame == heights.frame) {
        layers.push("terrain_class".to_owned());
        data.push(layer(rows, cols, |at| match classes.data.get(at) {
            Some(&class) if class != UNKNOWN => f32::from(class),
            _ => f32::NAN,
        }));
    }
    let middle = |origin: f64, n: u32| origin + 0.5 * resolution * (f64::from(n) - 1.0);
    GridMap {
        header: header(nanoseconds, frame::MAP),
        info: GridMapInfo {
            resolution,
            length_x: f64::from(cols) * resolution,
            length_y: f64::from(rows) * resolution,
            pose: pose(middle(origin_x, cols), middle(origin_y, rows)),
        },
        layers,
        basic_layers: vec!["elevation".to_owned()],
        data,
        outer_start_index: 0,
        inner_start_index: 0,
    }
}

/// A layer of a grid map from samples that lie row-major from the south-west; `at` gives the sample of an index.
fn layer(rows: u32, cols: u32, at: impl Fn(usize) -> f32) -> Float32MultiArray {
    let (north, east) = (rows as usize, cols as usize);
    let mut data = Vec::with_capacity(north * east);
    for row in (0..north).rev() {
        data.extend((0..east).rev().map(|col| at(row * east + col)));
    }
    let dimension =
        |label: &str, size: u32, stride: u32| MultiArrayDimension { label: label.to_owned(), size, stride };
    Float32MultiArray {
        layout: MultiArrayLayout {
            dim: vec![
                dimension("column_index", rows, rows.saturating_mul(cols)),
                dimension("row_index", cols, cols),
            ],
            data_offset: 0,
        },
        data,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three samples along x and two along y, 0.5 m apart, the first at (10, 20).
    const FRAME: GridFrame = GridFrame { rows: 2, cols: 3, resolution: 0.5, origin_x: 10.0, origin_y: 20.0 };

    #[test]
    fn cells_of_an_occupancy_grid_begin_half_a_cell_before_their_samples() {
        let grid = occupancy_grid(0, &LabelMap { frame: FRAME, data: vec![0, 1, 255, 0, 0, 1] });
        assert_eq!((grid.info.width, grid.info.height, grid.info.resolution), (3, 2, 0.5));
        assert_eq!((grid.info.origin.position.x, grid.info.origin.position.y), (9.75, 19.75));
        assert_eq!(grid.data, [0, 100, -1, 0, 0, 100]);
    }

    #[test]
    fn a_grid_map_begins_at_the_greatest_coordinates() {
        let heights = HeightMap { frame: FRAME, data: vec![1.0, 2.0, 3.0, 4.0, 5.0, f32::NAN] };
        let classes = LabelMap { frame: FRAME, data: vec![0, 1, 2, 3, 255, 5] };
        let map = elevation_map(0, &heights, Some(&classes));
        assert_eq!(map.layers, ["elevation", "terrain_class"]);
        // The middle of the samples; the map reaches half a cell beyond them.
        assert_eq!((map.info.pose.position.x, map.info.pose.position.y), (10.5, 20.25));
        assert_eq!((map.info.length_x, map.info.length_y), (1.5, 1.0));
        let elevation = &map.data[0];
        assert_eq!([elevation.layout.dim[0].size, elevation.layout.dim[1].size], [2, 3]);
        // Sample (i, j) of the matrix lies at data[3 j + i], at x = 11 − 0.5 i, y = 20.5 − 0.5 j.
        assert!(elevation.data[0].is_nan());
        assert_eq!(elevation.data[1..], [5.0, 4.0, 3.0, 2.0, 1.0]);
        assert!(map.data[1].data[1].is_nan());
        assert_eq!(map.data[1].data[2], 3.0);
        // Classes on another grid have no place here.
        let other = LabelMap { frame: GridFrame { rows: 1, ..FRAME }, data: vec![0; 3] };
        assert_eq!(elevation_map(0, &heights, Some(&other)).layers, ["elevation"]);
    }
}
