//! Values, what they are made of, and what of their bits is seen.

use super::operators::{Shape, Width};

/// A value of a function: the result of an operator, or the join of several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Value(u32);

impl Value {
    /// All values that no arithmetic of this function has made: of them nothing needs to be known.
    pub(super) const OPAQUE: Self = Self(0);
}

/// What of a value's bits is seen, by anything that it flows to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Demand(u8);

impl Demand {
    const NONE: Self = Self(0);
    /// All bits are seen.
    pub(super) const EXACT: Self = Self(4);

    /// Lanes of this width are read as numbers: of a NaN no more is seen than that it is one.
    pub(super) fn numbers(width: Width) -> Self {
        match width {
            Width::W32 => Self(1),
            Width::W64 => Self(2),
        }
    }

    fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether arithmetic in lanes of this width has to make canonical NaNs. To a reader of lanes of another width, a
    /// NaN is two numbers or a part of one.
    fn needs_canonical(self, width: Width) -> bool {
        !Self::numbers(width).contains(self)
    }
}

/// How an operator passes lanes of an operand on, which tells what a demand for the result means for the operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Passing {
    /// As they are, in whole lanes of any width.
    Whole,
    /// In whole lanes of this width; lanes of the other are put together anew, or change in more than their sign.
    Lanes(Width),
    /// In parts of lanes.
    Bits,
}

impl Passing {
    /// As lanes that stay whole in this width and in lower ones.
    pub(super) fn lanes_of(width: Option<Width>) -> Self {
        match width {
            Some(Width::W64) => Self::Whole,
            Some(Width::W32) => Self::Lanes(Width::W32),
            None => Self::Bits,
        }
    }

    fn demand(self, of_result: Demand) -> Demand {
        let unharmed = match self {
            Self::Whole => return of_result,
            Self::Lanes(width) => Demand::numbers(width).contains(of_result),
            Self::Bits => of_result == Demand::NONE,
        };
        if unharmed { of_result } else { Demand::EXACT }
    }
}

/// An operand of a value.
#[derive(Clone, Copy)]
struct Edge {
    result: Value,
    operand: Value,
    passing: Passing,
}

/// A value whose NaNs can be made canonical where it comes to be.
#[derive(Clone, Copy)]
struct Source {
    value: Value,
    site: Site,
    /// The source that it is the same number as, if it is no result of arithmetic itself.
    of: Option<usize>,
}

/// A place at which NaNs can be made canonical.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Site {
    /// Where the operator behind which it is ends in the file.
    pub(super) end: usize,
    pub(super) shape: Shape,
    /// The local that holds the number; if there is none, it is on the stack.
    pub(super) local: Option<u32>,
}

/// The values of one function.
pub(super) struct Graph {
    demands: Vec<Demand>,
    /// For each value the greatest lanes of which all bits are equal, if there are any.
    masks: Vec<Option<Width>>,
    edges: Vec<Edge>,
    sources: Vec<Source>,
}

impl Graph {
    pub(super) fn new() -> Self {
        Self { demands: vec![Demand::NONE], masks: vec![None], edges: Vec::new(), sources: Vec::new() }
    }

    fn add(&mut self, mask: Option<Width>) -> Value {
        // A function has fewer operators than bytes, and joins are bounded: the number fits by far.
        let value = Value(self.demands.len() as u32);
        self.demands.push(Demand::NONE);
        self.masks.push(mask);
        value
    }

    /// The result of arithmetic.
    pub(super) fn source(&mut self, site: Site) -> Value {
        let value = self.add(None);
        self.sources.push(Source { value, site, of: None });
        value
    }

    /// A number that goes on behind a loop, if it is one of arithmetic in the loop, whose first value is given. What is
    /// seen of it behind the loop needn't be canonical in each of its turns.
    pub(super) fn result_of_loop(
        &mut self,
        number: Value,
        first: Value,
        end: usize,
        local: u32,
    ) -> Option<Value> {
        let of = self.sources.binary_search_by_key(&number.0, |source| source.value.0).ok()?;
        if number.0 < first.0 {
            return None;
        }
        let value = self.add(None);
        let site = Site { end, shape: self.sources[of].site.shape, local: Some(local) };
        self.sources.push(Source { value, site, of: Some(of) });
        Some(value)
    }

    /// A vector whose lanes have all bits set or none.
    pub(super) fn mask(&mut self, lanes: Option<Width>) -> Value {
        lanes.map_or(Value::OPAQUE, |_| self.add(lanes))
    }

    /// The greatest lanes of which a value is a mask, if it is one.
    pub(super) fn lanes_of_mask(&self, value: Value) -> Option<Width> {
        self.masks[value.0 as usize]
    }

    /// A value that consists of parts of others.
    pub(super) fn passed(&mut self, operands: &[Value], passing: Passing) -> Value {
        if operands.iter().all(|operand| *operand == Value::OPAQUE) {
            return Value::OPAQUE;
        }
        let result = self.add(None);
        for operand in operands {
            self.pass(*operand, result, passing);
        }
        result
    }

    /// A value that is to get its operands by and by.
    pub(super) fn join(&mut self) -> Value {
        self.add(None)
    }

    /// Has a value become a part of another.
    pub(super) fn pass(&mut self, operand: Value, result: Value, passing: Passing) {
        if operand != Value::OPAQUE && operand != result {
            self.edges.push(Edge { result, operand, passing });
        }
    }

    /// How often a value has become a part of another.
    pub(super) fn passings(&self) -> usize {
        self.edges.len()
    }

    /// Notes what something that is no part of the graph sees of a value.
    pub(super) fn demand(&mut self, value: Value, demand: Demand) {
        let all = &mut self.demands[value.0 as usize];
        *all = all.and(demand);
    }

    /// The places where NaNs have to be made canonical, in the order of the operators.
    pub(super) fn sites(mut self) -> Vec<Site> {
        self.settle();
        let mut canonical = Vec::with_capacity(self.sources.len());
        let mut sites = Vec::new();
        for source in &self.sources {
            let demand = self.demands[source.value.0 as usize];
            let already = source.of.is_some_and(|of| canonical[of]);
            let needed = demand.needs_canonical(source.site.shape.width());
            if needed && !already {
                sites.push(source.site);
            }
            canonical.push(needed || already);
        }
        sites
    }

    /// Hands each demand on to the operands, until nothing changes any more.
    fn settle(&mut self) {
        self.edges.sort_by_key(|edge| edge.result.0);
        let mut first = vec![0; self.demands.len() + 1];
        for edge in &self.edges {
            first[edge.result.0 as usize + 1] += 1;
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let seen = |demand: &Demand| *demand != Demand::NONE;
        let mut changed: Vec<usize> = (0..self.demands.len()).filter(|i| seen(&self.demands[*i])).collect();
        while let Some(result) = changed.pop() {
            for edge in &self.edges[first[result]..first[result + 1]] {
                let demand = edge.passing.demand(self.demands[result]);
                let operand = edge.operand.0 as usize;
                if !self.demands[operand].contains(demand) {
                    self.demands[operand] = self.demands[operand].and(demand);
                    changed.push(operand);
                }
            }
        }
    }
}
