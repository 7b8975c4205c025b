//! Best-first search over numbered nodes: Dijkstra's algorithm, and A* where there is an estimate of what is left.
//!
//! The caller numbers the nodes, names the neighbours and adds up the costs; the search keeps the open list, the costs
//! and the parents. So the same few lines serve grids, grids with headings and graphs of any other kind.
//!
//! Here a way is found over a grid of 5 × 4 cells, numbered row by row, around a wall:
//!
//! ```
//! use vb_math::search::Search;
//!
//! let (rows, cols) = (4_usize, 5_usize);
//! let blocked = |row: usize, col: usize| col == 2 && row < 3;
//! let (start, goal) = (0, 4);
//! // The least cost that can be left: the number of steps along rows and columns.
//! let left = |row: usize, col: usize| (row + (cols - 1 - col)) as f64;
//!
//! let mut search = Search::new(rows * cols);
//! search.start(start, left(0, 0));
//! while let Some(node) = search.pop() {
//!     if node == goal {
//!         break;
//!     }
//!     let (row, col) = (node / cols, node % cols);
//!     for (r, c) in [(row + 1, col), (row, col + 1), (row.wrapping_sub(1), col), (row, col.wrapping_sub(1))] {
//!         if r < rows && c < cols && !blocked(r, c) {
//!             search.offer(r * cols + c, node, search.cost(node) + 1.0, left(r, c));
//!         }
//!     }
//! }
//! // Down to the last row, past the wall, and up again.
//! assert_eq!(search.cost(goal), 10.0);
//! assert_eq!(search.path(goal).len(), 11);
//! ```

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::fmt::Debug;
use std::ops::Add;

/// Marks a node without a parent.
const NONE: u32 = u32::MAX;

/// A number that costs are counted in: `f32` or `f64`.
pub trait Cost: Copy + PartialOrd + Add<Output = Self> {
    /// The cost at a start.
    const ZERO: Self;
    /// The cost of a node that no way leads to.
    const INFINITY: Self;
    /// A whole number that is in the order of the costs, which is cheaper to compare.
    type Key: Copy + Debug + Ord;

    /// The place in the order of all values (IEEE 754, totalOrder), so that even those that are no numbers have theirs.
    fn key(self) -> Self::Key;
}

impl Cost for f32 {
    const ZERO: Self = 0.0;
    const INFINITY: Self = f32::INFINITY;
    type Key = i32;

    fn key(self) -> i32 {
        // Bits of positive numbers are in their order, and those of negative ones, but for the sign, in the opposite one.
        let bits = self.to_bits().cast_signed();
        if bits < 0 { bits ^ i32::MAX } else { bits }
    }
}

impl Cost for f64 {
    const ZERO: Self = 0.0;
    const INFINITY: Self = f64::INFINITY;
    type Key = i64;

    fn key(self) -> i64 {
        let bits = self.to_bits().cast_signed();
        if bits < 0 { bits ^ i64::MAX } else { bits }
    }
}

/// A search from one start or several (Dijkstra, *Numerische Mathematik* 1, 1959; Hart, Nilsson, Raphael, *IEEE
/// Transactions on Systems Science and Cybernetics* 4, 1968).
///
/// Of the open nodes the one with the least sum of its cost and of what is estimated to be left is taken first, and of
/// those with equal sums the one with the smallest number. So the result depends on the costs alone and is the same
/// everywhere. Each node is taken once: with a consistent estimate (which falls along no step by more than the step costs)
/// the way to it is then the cheapest; with another one it may not be.
#[derive(Clone, Debug)]
pub struct Search<C: Cost> {
    cost: Vec<C>,
    parent: Vec<u32>,
    closed: Vec<bool>,
    open: BinaryHeap<Reverse<Open<C::Key>>>,
}

impl<C: Cost> Search<C> {
    /// A search over the nodes 0 to `nodes` − 1, of which none is open yet.
    ///
    /// # Panics
    /// Panics if there are 2³² − 1 nodes or more.
    #[must_use]
    pub fn new(nodes: usize) -> Self {
        assert!(nodes < NONE as usize, "{nodes} nodes are more than a search can number");
        Self {
            cost: vec![C::INFINITY; nodes],
            parent: vec![NONE; nodes],
            closed: vec![false; nodes],
            open: BinaryHeap::new(),
        }
    }

    /// Opens a node from which the search starts, at no cost. `left` is as in [`Search::offer`].
    pub fn start(&mut self, node: usize, left: C) {
        self.cost[node] = C::ZERO;
        self.open.push(Reverse(Open { estimate: (C::ZERO + left).key(), node: node as u32 }));
    }

    /// Takes the best open node; `None` if none is left. Its cost and its parent don't change any more.
    pub fn pop(&mut self) -> Option<usize> {
        while let Some(Reverse(Open { node, .. })) = self.open.pop() {
            let node = node as usize;
            // A node lies in the heap once for each improvement; the first that comes out is the last of them.
            if !std::mem::replace(&mut self.closed[node], true) {
                return Some(node);
            }
        }
        None
    }

    /// The cost of the best way to a node that was found so far; infinite if there is none.
    #[must_use]
    pub fn cost(&self, node: usize) -> C {
        self.cost[node]
    }

    /// Whether a way of this cost to a node would be better than all before. Ask this before a costly check of whether
    /// the way is free.
    #[must_use]
    pub fn improves(&self, node: usize, cost: C) -> bool {
        !self.closed[node] && cost < self.cost[node]
    }

    /// Offers a way to a node, which is taken if it is better than all before.
    ///
    /// `cost` is that of the whole way, over `parent`, the node before; `left` is an estimate of the least cost that is
    /// left from the node to the goal, which should not be more than it is, and is zero for Dijkstra's algorithm.
    pub fn offer(&mut self, node: usize, parent: usize, cost: C, left: C) {
        if self.improves(node, cost) {
            self.cost[node] = cost;
            self.parent[node] = parent as u32;
            self.open.push(Reverse(Open { estimate: (cost + left).key(), node: node as u32 }));
        }
    }

    /// The nodes of the best way to a node that was found so far, from its start to the node itself; empty if there is
    /// none.
    #[must_use]
    pub fn path(&self, node: usize) -> Vec<usize> {
        let mut path = Vec::new();
        if self.cost[node] < C::INFINITY {
            path.push(node);
            let mut at = self.parent[node];
            while at != NONE {
                path.push(at as usize);
                at = self.parent[at as usize];
            }
            path.reverse();
        }
        path
    }

    /// The costs of the best ways to all nodes, infinite where there is none. After a search to its end with no estimate
    /// they are the distances from the nearest start.
    #[must_use]
    pub fn into_costs(self) -> Vec<C> {
        self.cost
    }
}

/// An entry of the open list, in the order in which nodes are taken: by the estimate, then by the number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Open<K> {
    estimate: K,
    node: u32,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;

    /// Edges (from, to, cost) of a graph drawn by a seed.
    fn graph(nodes: u64, edges: usize, rng: &mut Stream) -> Vec<(usize, usize, f64)> {
        let mut node = || rng.below(nodes) as usize;
        let ends: Vec<_> = (0..edges).map(|_| (node(), node())).collect();
        // Small whole costs make many ties.
        ends.into_iter().map(|(a, b)| (a, b, rng.below(4) as f64)).collect()
    }

    fn dijkstra(nodes: usize, edges: &[(usize, usize, f64)], starts: &[usize]) -> Search<f64> {
        let mut search = Search::new(nodes);
        starts.iter().for_each(|start| search.start(*start, 0.0));
        while let Some(node) = search.pop() {
            for (_, to, step) in edges.iter().filter(|edge| edge.0 == node) {
                search.offer(*to, node, search.cost(node) + step, 0.0);
            }
        }
        search
    }

    /// The distances by relaxing all edges until nothing changes (Bellman 1958, Ford 1956).
    fn distances(nodes: usize, edges: &[(usize, usize, f64)], starts: &[usize]) -> Vec<f64> {
        let mut cost = vec![f64::INFINITY; nodes];
        starts.iter().for_each(|start| cost[*start] = 0.0);
        for _ in 0..nodes {
            for (from, to, step) in edges {
                cost[*to] = cost[*to].min(cost[*from] + step);
            }
        }
        cost
    }

    #[test]
    fn costs_are_the_distances_and_paths_have_them() {
        let mut rng = Stream::new(1, &["search"]);
        for _ in 0..200 {
            let edges = graph(30, 60, &mut rng);
            let starts = [rng.below(30) as usize, rng.below(30) as usize];
            let search = dijkstra(30, &edges, &starts);
            let expected = distances(30, &edges, &starts);
            for (node, distance) in expected.iter().enumerate() {
                assert_eq!(search.cost(node), *distance);
                let path = search.path(node);
                assert_eq!(path.is_empty(), distance.is_infinite());
                assert!(path.first().is_none_or(|first| starts.contains(first)));
                let cheapest = |from, to| {
                    let steps = edges.iter().filter(|edge| (edge.0, edge.1) == (from, to)).map(|edge| edge.2);
                    steps.fold(f64::INFINITY, f64::min)
                };
                let length: f64 = path.windows(2).map(|pair| cheapest(pair[0], pair[1])).sum();
                assert!(path.is_empty() || length == *distance);
            }
            assert_eq!(search.into_costs(), expected);
        }
    }

    #[test]
    fn a_consistent_estimate_takes_fewer_nodes_to_the_same_cost() {
        // A free grid of 21 × 21 cells, from the middle to the middle of an edge.
        let run = |left: fn(usize) -> f32| {
            let mut search = Search::new(441);
            search.start(220, left(220));
            let mut taken = 0;
            while let Some(node) = search.pop() {
                taken += 1;
                if node == 230 {
                    break;
                }
                let (row, col) = (node / 21, node % 21);
                for (r, c) in
                    [(row.wrapping_sub(1), col), (row + 1, col), (row, col.wrapping_sub(1)), (row, col + 1)]
                {
                    if r < 21 && c < 21 {
                        search.offer(r * 21 + c, node, search.cost(node) + 1.0, left(r * 21 + c));
                    }
                }
            }
            (search.cost(230), taken)
        };
        let manhattan = |node: usize| ((node / 21).abs_diff(10) + (node % 21).abs_diff(20)) as f32;
        assert_eq!(run(manhattan), (10.0, 11));
        let (cost, taken) = run(|_| 0.0);
        assert!(cost == 10.0 && taken > 150, "{cost}, {taken}");
    }

    #[test]
    fn of_equal_estimates_the_smallest_number_is_taken_first_whatever_came_first() {
        let mut rng = Stream::new(2, &["search"]);
        for _ in 0..100 {
            let mut search = Search::new(8);
            search.start(0, 0.0);
            assert_eq!(search.pop(), Some(0));
            // Two groups: 1 to 4 at cost 2 with 1 left, 5 to 7 at cost 1 with 1 left.
            let mut nodes: Vec<usize> = (1..8).collect();
            for k in (1..nodes.len()).rev() {
                nodes.swap(k, rng.below(k as u64 + 1) as usize);
            }
            nodes.iter().for_each(|n| search.offer(*n, 0, if *n < 5 { 2.0 } else { 1.0 }, 1.0));
            let order: Vec<usize> = std::iter::from_fn(|| search.pop()).collect();
            assert_eq!(order, [5, 6, 7, 1, 2, 3, 4]);
        }
    }

    #[test]
    fn keys_are_in_the_total_order_of_the_numbers() {
        let all = [
            f64::NEG_INFINITY,
            -2.5,
            -1.0,
            -f64::MIN_POSITIVE,
            -0.0,
            0.0,
            1e-300,
            1.0,
            2.5,
            f64::INFINITY,
            f64::NAN,
        ];
        for a in all {
            for b in all {
                assert_eq!(a.key().cmp(&b.key()), a.total_cmp(&b), "{a}, {b}");
                let (a, b) = (a as f32, b as f32);
                assert_eq!(a.key().cmp(&b.key()), a.total_cmp(&b), "{a}, {b}");
            }
        }
    }

    #[test]
    fn a_node_that_was_taken_is_not_taken_again() {
        let mut search = Search::new(2);
        search.start(0, 0.0);
        search.offer(1, 0, 3.0, 0.0);
        search.offer(1, 0, 2.0, 0.0);
        assert_eq!((search.pop(), search.pop(), search.pop()), (Some(0), Some(1), None));
        assert!(!search.improves(1, 1.0));
        search.offer(1, 0, 1.0, 0.0);
        assert_eq!((search.pop(), search.cost(1)), (None, 2.0));
        // What is no number is no way.
        let mut search = Search::new(1);
        search.offer(0, 0, f64::NAN, 0.0);
        assert_eq!((search.pop(), search.path(0)), (None, vec![]));
    }
}
