//! Best-first search over numbered nodes, for path search on a grid before the start: Dijkstra's algorithm and A*, with
//! platform-independent tie breaking.
//!
//! The example searches the occupancy map of a task. A node is a cell, numbered row by row; a step goes to one of the
//! eight neighbours, and the heuristic is the Euclidean distance:
//!
//! ```
//! use vb_sdk::search::Search;
//! use vb_sdk::{GridFrame, Map, Point2, math};
//!
//! fn way(occupancy: &Map<u8>, start: Point2, goal: Point2) -> Option<Vec<Point2>> {
//!     let GridFrame { rows, cols, resolution, .. } = occupancy.frame;
//!     let node = |p: Point2| {
//!         let (row, col) = occupancy.frame.fractional(p.x, p.y);
//!         let nearest = |v: f64, n: u32| (v.round().max(0.0) as usize).min(n as usize - 1);
//!         nearest(row, rows) * cols as usize + nearest(col, cols)
//!     };
//!     let place = |node: usize| {
//!         let (x, y) = occupancy.frame.position(node as u32 / cols, node as u32 % cols);
//!         Point2 { x, y }
//!     };
//!     let left = |node: usize| math::hypot(place(node).x - goal.x, place(node).y - goal.y);
//!     let last = node(goal);
//!     let mut search = Search::new(rows as usize * cols as usize);
//!     search.start(node(start), 0.0);
//!     while let Some(at) = search.pop() {
//!         if at == last {
//!             return Some(search.path(at).into_iter().map(place).collect());
//!         }
//!         let (row, col) = (at as i64 / i64::from(cols), at as i64 % i64::from(cols));
//!         for (dr, dc) in [(-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1)] {
//!             let (r, c) = (row + dr, col + dc);
//!             if !(0..i64::from(rows)).contains(&r) || !(0..i64::from(cols)).contains(&c) {
//!                 continue;
//!             }
//!             let next = (r * i64::from(cols) + c) as usize;
//!             if occupancy.data[next] == 0 {
//!                 let step = resolution * ((dr * dr + dc * dc) as f64).sqrt();
//!                 search.offer(next, at, search.cost(at) + step, left(next));
//!             }
//!         }
//!     }
//!     None
//! }
//!
//! // A wall of 10 m with a gap in the north, in a world of 20 m.
//! let frame = GridFrame { rows: 21, cols: 21, resolution: 1.0, origin_x: -10.0, origin_y: -10.0 };
//! let mut data = vec![0; 441];
//! (0..15).for_each(|row| data[row * 21 + 10] = 1);
//! let map = Map { frame, data };
//! let path = way(&map, Point2 { x: -8.0, y: 0.0 }, Point2 { x: 8.0, y: 0.0 }).unwrap();
//! assert!(path.iter().any(|p| p.y >= 5.0));
//! ```

pub use vb_math::search::{Cost, Search};
