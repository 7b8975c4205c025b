//! The walk through one function that finds the arithmetic whose NaNs have to be canonical.
//!
//! It follows values over the operand stack and through the locals, and joins those of locals where branches meet, as a
//! compiler does on the way to its single assignments. What blocks hand over on the stack, what calls take and give, and
//! what is in memory is not followed: it counts as seen, and what comes back as unknown.

use std::collections::BTreeSet;

use wasmparser::{BinaryReaderError, FuncValidator, FunctionBody, Operator, ValType, WasmModuleResources};

use super::graph::{Demand, Graph, Passing, Site, Value};
use super::operators::{Action, action};

/// The number of locals' values that may be copied and compared at the branches of one function. The code of compilers
/// needs a small part of it. In a function that needs more all arithmetic is made canonical, so that the time of this
/// pass and its memory have a bound.
const MAX_WORK: usize = 1 << 26;
/// What it counts that a value becomes a part of another, which takes more memory.
const WORK_OF_PASSING: usize = 8;

/// The function can't be followed.
struct Lost;

/// The places of a function at which NaNs have to be made canonical, in their order. The validator is that of the
/// function and has read nothing yet; in the end it has checked the function.
pub(super) fn sites<R: WasmModuleResources>(
    body: &FunctionBody<'_>,
    validator: &mut FuncValidator<R>,
) -> Result<Vec<Site>, BinaryReaderError> {
    validator.read_locals(&mut body.get_binary_reader())?;
    let slots = Slots::new(validator);
    let mut walk = writes_in_loops(body, &slots)?.map(|writes| Walk::new(slots, writes));
    let mut all = Vec::new();
    let mut operators = body.get_operators_reader()?;
    while !operators.eof() {
        let offset = operators.original_position();
        let operator = operators.read()?;
        let arity = operator.operator_arity(validator);
        validator.op(offset, &operator)?;
        let end = operators.original_position();
        if let Action::Arithmetic { makes, .. } = action(&operator) {
            all.push(Site { end, shape: makes, local: None });
        }
        let stepped = walk.take().zip(arity).map(|(mut walk, (pops, pushes))| {
            walk.step(&operator, pops as usize, pushes as usize, end)?;
            walk.agrees_with(validator).then_some(walk).ok_or(Lost)
        });
        walk = stepped.and_then(Result::ok);
    }
    operators.finish()?;
    Ok(walk.map_or(all, |walk| walk.graph.sites()))
}

/// The locals that can hold floats, which are numbered anew.
struct Slots {
    /// For each local its slot, if it has one.
    of_locals: Vec<Option<usize>>,
    /// For each slot its local.
    locals: Vec<u32>,
}

impl Slots {
    fn new<R: WasmModuleResources>(validator: &FuncValidator<R>) -> Self {
        let mut slots = Self { of_locals: Vec::new(), locals: Vec::new() };
        for local in 0..validator.len_locals() {
            let holds_floats =
                matches!(validator.get_local_type(local), Some(ValType::F32 | ValType::F64 | ValType::V128));
            slots.of_locals.push(holds_floats.then_some(slots.locals.len()));
            if holds_floats {
                slots.locals.push(local);
            }
        }
        slots
    }

    fn of(&self, local: u32) -> Option<usize> {
        self.of_locals.get(local as usize).copied().flatten()
    }
}

/// For each loop, in the order in which they begin, the locals that are set in it; `None` where that is too much.
fn writes_in_loops(
    body: &FunctionBody<'_>,
    slots: &Slots,
) -> Result<Option<Vec<Vec<usize>>>, BinaryReaderError> {
    let mut loops: Vec<BTreeSet<usize>> = Vec::new();
    // The blocks that are open, and which of them are loops.
    let mut open: Vec<Option<usize>> = Vec::new();
    let mut innermost: Vec<usize> = Vec::new();
    let mut work = 0;
    let mut operators = body.get_operators_reader()?;
    while !operators.eof() {
        match operators.read()? {
            Operator::Loop { .. } => {
                innermost.push(loops.len());
                open.push(Some(loops.len()));
                loops.push(BTreeSet::new());
            }
            Operator::Block { .. } | Operator::If { .. } => open.push(None),
            Operator::End => {
                let Some(Some(ended)) = open.pop() else { continue };
                innermost.pop();
                if let Some(outer) = innermost.last() {
                    work += loops[ended].len();
                    let writes = loops[ended].clone();
                    loops[*outer].extend(writes);
                }
            }
            Operator::LocalSet { local_index } | Operator::LocalTee { local_index } => {
                if let (Some(slot), Some(innermost)) = (slots.of(local_index), innermost.last()) {
                    loops[*innermost].insert(slot);
                }
            }
            _ => {}
        }
        if work > MAX_WORK {
            return Ok(None);
        }
    }
    Ok(Some(loops.into_iter().map(|writes| writes.into_iter().collect()).collect()))
}

/// A block that is open.
struct Frame {
    /// The height of the operand stack below the block's operands.
    height: usize,
    /// Whether it was entered at all: in a block that wasn't, nothing is.
    live: bool,
    label: Label,
}

/// Where the branches to a block go.
enum Label {
    /// To its end, with these values of the locals so far.
    End(Option<Vec<Value>>),
    /// As before; the second are the values where its condition doesn't hold, until they are taken up by its `else`.
    EndOfIf(Option<Vec<Value>>, Option<Vec<Value>>),
    /// To its begin, where these joins of locals are, the first of the loop's values.
    Begin(Vec<(usize, Value)>),
}

/// The state of the walk between two operators.
struct Walk {
    graph: Graph,
    slots: Slots,
    /// The values of the locals, by slot.
    locals: Vec<Value>,
    stack: Vec<Value>,
    frames: Vec<Frame>,
    reachable: bool,
    writes: std::vec::IntoIter<Vec<usize>>,
    work: usize,
}

impl Walk {
    fn new(slots: Slots, writes: Vec<Vec<usize>>) -> Self {
        let locals = vec![Value::OPAQUE; slots.locals.len()];
        let function = Frame { height: 0, live: true, label: Label::End(None) };
        Self {
            graph: Graph::new(),
            slots,
            locals,
            stack: Vec::new(),
            frames: vec![function],
            reachable: true,
            writes: writes.into_iter(),
            work: 0,
        }
    }

    /// Whether the validator has as many operands and open blocks.
    fn agrees_with<R: WasmModuleResources>(&self, validator: &FuncValidator<R>) -> bool {
        let blocks = validator.control_stack_height() as usize;
        let operands = validator.operand_stack_height() as usize;
        blocks == self.frames.len() && (!self.reachable || blocks == 0 || operands == self.stack.len())
    }

    /// Takes one operator, which ends there in the file.
    fn step(&mut self, operator: &Operator<'_>, pops: usize, pushes: usize, end: usize) -> Result<(), Lost> {
        match operator {
            Operator::Block { .. } => self.enter(pushes, |_| Label::End(None)),
            Operator::If { .. } => {
                if self.reachable {
                    self.observe(1);
                }
                self.enter(pushes, |walk| {
                    walk.work += walk.locals.len();
                    Label::EndOfIf(None, Some(walk.locals.clone()))
                });
            }
            Operator::Loop { .. } => {
                let writes = self.writes.next().ok_or(Lost)?;
                self.enter(pushes, |walk| Label::Begin(walk.joins(&writes)));
            }
            Operator::Else => self.otherwise(pops, pushes)?,
            Operator::End => self.leave(pops, pushes, end)?,
            _ if !self.reachable => {}
            Operator::Br { relative_depth } => {
                self.observe(pops);
                self.branch(*relative_depth)?;
                self.reachable = false;
            }
            Operator::BrIf { relative_depth } => {
                self.observe(pops);
                self.unknown(pushes);
                self.branch(*relative_depth)?;
            }
            Operator::BrTable { targets } => {
                self.observe(pops);
                let depths: Result<BTreeSet<u32>, _> = targets.targets().collect();
                let mut depths = depths.map_err(|_| Lost)?;
                depths.insert(targets.default());
                for depth in depths {
                    self.branch(depth)?;
                }
                self.reachable = false;
            }
            Operator::Return
            | Operator::Unreachable
            | Operator::ReturnCall { .. }
            | Operator::ReturnCallIndirect { .. }
            | Operator::ReturnCallRef { .. }
            | Operator::Throw { .. }
            | Operator::ThrowRef
            | Operator::Rethrow { .. } => {
                self.observe(pops);
                self.reachable = false;
            }
            Operator::LocalGet { local_index } => {
                let value = self.slots.of(*local_index).map_or(Value::OPAQUE, |slot| self.locals[slot]);
                self.stack.push(value);
            }
            Operator::LocalSet { local_index } | Operator::LocalTee { local_index } => {
                let value = self.pop();
                if let Some(slot) = self.slots.of(*local_index) {
                    self.locals[slot] = value;
                }
                self.stack.extend(std::iter::repeat_n(value, pushes));
            }
            _ => self.compute(action(operator), pops, pushes, end)?,
        }
        if self.work + WORK_OF_PASSING * self.graph.passings() > MAX_WORK { Err(Lost) } else { Ok(()) }
    }

    /// Takes an operator that does no more than to make values of values.
    fn compute(&mut self, action: Action, pops: usize, pushes: usize, end: usize) -> Result<(), Lost> {
        let below = self.stack.len().checked_sub(pops).ok_or(Lost)?;
        let operands = self.stack.split_off(below);
        let graph = &mut self.graph;
        let observe = |graph: &mut Graph, values: &[Value], demand| {
            values.iter().for_each(|value| graph.demand(*value, demand));
        };
        let result = match (action, operands.as_slice()) {
            (Action::Arithmetic { reads, makes }, operands) => {
                observe(graph, operands, Demand::numbers(reads));
                graph.source(Site { end, shape: makes, local: None })
            }
            (Action::Reading(width), operands) => {
                observe(graph, operands, Demand::numbers(width));
                Value::OPAQUE
            }
            (Action::Comparison(width), operands) => {
                observe(graph, operands, Demand::numbers(width));
                graph.mask(Some(width))
            }
            (Action::BitComparison(width), operands) => {
                observe(graph, operands, Demand::EXACT);
                graph.mask(Some(width))
            }
            (Action::Constant(lanes), _) => graph.mask(lanes),
            (Action::Sign(width) | Action::Lanes(width), operands) => {
                graph.passed(operands, Passing::Lanes(width))
            }
            (Action::CopySign(width), [numbers, sign]) => {
                observe(graph, &[*sign], Demand::EXACT);
                graph.passed(&[*numbers], Passing::Lanes(width))
            }
            (Action::Pick(width), operands) => {
                observe(graph, operands, Demand::numbers(width));
                graph.passed(operands, Passing::Lanes(width))
            }
            (Action::Select, [a, b, _]) => graph.passed(&[*a, *b], Passing::Whole),
            (Action::BitSelect, [a, b, mask]) => {
                observe(graph, &[*mask], Demand::EXACT);
                let passing = Passing::lanes_of(graph.lanes_of_mask(*mask));
                graph.passed(&[*a, *b], passing)
            }
            (Action::And, [a, b]) => match (graph.lanes_of_mask(*a), graph.lanes_of_mask(*b)) {
                (Some(a), Some(b)) => graph.mask(Some(a.min(b))),
                (Some(mask), None) => graph.passed(&[*b], Passing::lanes_of(Some(mask))),
                (None, mask) => graph.passed(&[*a, *b], Passing::lanes_of(mask)),
            },
            (Action::AndNot, [a, b]) => match (graph.lanes_of_mask(*a), graph.lanes_of_mask(*b)) {
                (Some(a), Some(b)) => graph.mask(Some(a.min(b))),
                (_, mask) => graph.passed(&[*a, *b], Passing::lanes_of(mask)),
            },
            (Action::Combination, operands) => {
                observe(graph, operands, Demand::EXACT);
                let lanes = operands.iter().map(|operand| graph.lanes_of_mask(*operand)).min();
                graph.mask(lanes.flatten())
            }
            (Action::Shuffle(lanes), operands) => graph.passed(operands, Passing::lanes_of(lanes)),
            (Action::Drop, _) => Value::OPAQUE,
            (Action::Detour, _) => return Err(Lost),
            (_, operands) => {
                observe(graph, operands, Demand::EXACT);
                Value::OPAQUE
            }
        };
        match pushes {
            1 => self.stack.push(result),
            _ => self.unknown(pushes),
        }
        Ok(())
    }

    fn pop(&mut self) -> Value {
        self.stack.pop().unwrap_or(Value::OPAQUE)
    }

    /// Has all bits of the topmost operands be seen, and takes them away.
    fn observe(&mut self, count: usize) {
        for _ in 0..count {
            let value = self.pop();
            self.graph.demand(value, Demand::EXACT);
        }
    }

    /// Puts values on the stack of which nothing is known.
    fn unknown(&mut self, count: usize) {
        self.stack.extend(std::iter::repeat_n(Value::OPAQUE, count));
    }

    /// Enters a block with so many operands.
    fn enter(&mut self, operands: usize, label: impl FnOnce(&mut Self) -> Label) {
        let live = self.reachable;
        let mut frame = Frame { height: self.stack.len(), live, label: Label::End(None) };
        if live {
            self.observe(operands);
            frame.height = self.stack.len();
            self.unknown(operands);
            frame.label = label(self);
        }
        self.frames.push(frame);
    }

    /// Puts joins for the locals that a loop sets, and sets the locals to them.
    fn joins(&mut self, writes: &[usize]) -> Vec<(usize, Value)> {
        self.work += writes.len();
        let mut joins = Vec::with_capacity(writes.len());
        for slot in writes {
            let join = self.graph.join();
            let before = std::mem::replace(&mut self.locals[*slot], join);
            self.graph.pass(before, join, Passing::Whole);
            joins.push((*slot, join));
        }
        joins
    }

    /// Takes the locals that a loop has set out of it.
    fn take_out(&mut self, joins: &[(usize, Value)], end: usize) {
        let Some((_, first)) = joins.first() else { return };
        for (slot, _) in joins {
            let value = &mut self.locals[*slot];
            let local = self.slots.locals[*slot];
            *value = self.graph.result_of_loop(*value, *first, end, local).unwrap_or(*value);
        }
    }

    /// Takes the values of the locals to the label of a block.
    fn branch(&mut self, depth: u32) -> Result<(), Lost> {
        let frame = self.frames.iter_mut().nth_back(depth as usize).ok_or(Lost)?;
        match &mut frame.label {
            Label::End(states) | Label::EndOfIf(states, _) => {
                self.work += self.locals.len();
                merge(&mut self.graph, states, &self.locals);
            }
            Label::Begin(joins) => {
                self.work += joins.len();
                for (slot, join) in joins {
                    self.graph.pass(self.locals[*slot], *join, Passing::Whole);
                }
            }
        }
        Ok(())
    }

    /// Ends the first half of an `if` with so many results, and begins the second with so many operands.
    fn otherwise(&mut self, results: usize, operands: usize) -> Result<(), Lost> {
        if !self.frames.last().ok_or(Lost)?.live {
            return Ok(());
        }
        if self.reachable {
            self.observe(results);
            self.branch(0)?;
        }
        let frame = self.frames.last_mut().ok_or(Lost)?;
        let Label::EndOfIf(_, otherwise) = &mut frame.label else { return Err(Lost) };
        self.locals = otherwise.take().ok_or(Lost)?;
        self.reachable = true;
        self.stack.truncate(frame.height);
        self.unknown(operands);
        Ok(())
    }

    /// Ends a block with so many results, there in the file.
    fn leave(&mut self, operands: usize, results: usize, end: usize) -> Result<(), Lost> {
        if self.reachable {
            self.observe(operands);
        }
        let frame = self.frames.pop().ok_or(Lost)?;
        if !frame.live {
            return Ok(());
        }
        let (mut states, otherwise) = match frame.label {
            Label::End(states) => (states, None),
            Label::EndOfIf(states, otherwise) => (states, otherwise),
            Label::Begin(joins) => {
                if self.reachable {
                    self.take_out(&joins, end);
                }
                (None, None)
            }
        };
        for arriving in
            [self.reachable.then(|| std::mem::take(&mut self.locals)), otherwise].into_iter().flatten()
        {
            self.work += arriving.len();
            merge(&mut self.graph, &mut states, &arriving);
        }
        self.reachable = states.is_some();
        self.locals = states.unwrap_or_default();
        self.stack.truncate(frame.height);
        if self.reachable {
            self.unknown(results);
        }
        Ok(())
    }
}

/// Joins values of the locals with those that came to the same label before.
fn merge(graph: &mut Graph, states: &mut Option<Vec<Value>>, arriving: &[Value]) {
    let Some(states) = states else {
        *states = Some(arriving.to_vec());
        return;
    };
    for (state, arriving) in states.iter_mut().zip(arriving) {
        if state != arriving {
            let join = graph.join();
            graph.pass(*state, join, Passing::Whole);
            graph.pass(*arriving, join, Passing::Whole);
            *state = join;
        }
    }
}
