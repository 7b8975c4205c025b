//! Operations on tensors that give the same bits on every machine.
//!
//! Candle adds up products and sums in the order that the processor's vectors suggest, some of them fused, and takes its sines and
//! exponentials from the C library, so that weights would differ in their last bits from one machine to the next. Here sums have one
//! order, nothing is fused, and elementary functions are those of [`vb_math`]. What candle does element by element (`+ - * /`,
//! square roots, the greater of two) is exact by IEEE 754 and stays candle's.

use candle_core::{CpuStorage, CustomOp1, CustomOp3, Device, Layout, Result, Shape, Tensor, bail};
use fearless_simd::{Level, dispatch};
use vb_sdk::nn::LEAK;

/// max(x, leak · x): the activation between layers.
///
/// # Errors
/// Returns an error if there is no memory.
pub fn rectify(x: &Tensor) -> Result<Tensor> {
    map(x, "rectify", |v| if v > 0.0 { v } else { v * LEAK }, |v| if v > 0.0 { 1.0 } else { LEAK })
}

/// Sines of angles in rad.
///
/// # Errors
/// Returns an error if there is no memory.
pub fn sin(x: &Tensor) -> Result<Tensor> {
    map(x, "sin", |v| vb_math::sin(f64::from(v)) as f32, |v| vb_math::cos(f64::from(v)) as f32)
}

/// Cosines of angles in rad.
///
/// # Errors
/// Returns an error if there is no memory.
pub fn cos(x: &Tensor) -> Result<Tensor> {
    map(x, "cos", |v| vb_math::cos(f64::from(v)) as f32, |v| -vb_math::sin(f64::from(v)) as f32)
}

/// log(1 + exp(x)), of which a cross entropy of logits is made.
///
/// # Errors
/// Returns an error if there is no memory.
pub fn soft_plus(x: &Tensor) -> Result<Tensor> {
    let value = |v: f32| {
        let v = f64::from(v);
        (v.max(0.0) + vb_math::ln(1.0 + vb_math::exp(-v.abs()))) as f32
    };
    map(x, "soft_plus", value, |v| (1.0 / (1.0 + vb_math::exp(-f64::from(v)))) as f32)
}

/// The mean of all elements.
///
/// # Errors
/// Returns an error if there is no memory.
pub fn mean(x: &Tensor) -> Result<Tensor> {
    x.contiguous()?.apply_op1(Mean)
}

/// Rows of inputs times weights (inputs × outputs), plus the bias.
///
/// # Errors
/// Returns an error if the sizes don't match.
pub fn dense(x: &Tensor, weights: &Tensor, bias: &Tensor) -> Result<Tensor> {
    x.contiguous()?.apply_op3(&weights.contiguous()?, &bias.contiguous()?, Dense)
}

/// One column as so many equal ones.
///
/// # Errors
/// Returns an error if there are several columns.
pub fn widen(column: &Tensor, width: usize) -> Result<Tensor> {
    let ones = Tensor::ones((1, width), column.dtype(), column.device())?;
    dense(column, &ones, &Tensor::zeros(width, column.dtype(), column.device())?)
}

/// A function of each element.
struct Map {
    name: &'static str,
    value: fn(f32) -> f32,
    /// Its derivative.
    slope: fn(f32) -> f32,
}

fn map(x: &Tensor, name: &'static str, value: fn(f32) -> f32, slope: fn(f32) -> f32) -> Result<Tensor> {
    x.contiguous()?.apply_op1(Map { name, value, slope })
}

impl CustomOp1 for Map {
    fn name(&self) -> &'static str {
        self.name
    }

    fn cpu_fwd(&self, storage: &CpuStorage, layout: &Layout) -> Result<(CpuStorage, Shape)> {
        let values = elements(storage, layout)?.iter().map(|v| (self.value)(*v)).collect();
        Ok((CpuStorage::F32(values), layout.shape().clone()))
    }

    fn bwd(&self, x: &Tensor, _: &Tensor, gradient: &Tensor) -> Result<Option<Tensor>> {
        let gradients = numbers(gradient)?;
        let own = numbers(x)?.iter().zip(gradients).map(|(v, g)| (self.slope)(*v) * g).collect();
        Tensor::from_vec(own, x.shape(), x.device()).map(Some)
    }
}

struct Mean;

impl CustomOp1 for Mean {
    fn name(&self) -> &'static str {
        "mean"
    }

    fn cpu_fwd(&self, storage: &CpuStorage, layout: &Layout) -> Result<(CpuStorage, Shape)> {
        let all = elements(storage, layout)?;
        let sum: f64 = all.iter().map(|v| f64::from(*v)).sum();
        Ok((CpuStorage::F32(vec![(sum / all.len() as f64) as f32]), Shape::from(())))
    }

    fn bwd(&self, x: &Tensor, _: &Tensor, gradient: &Tensor) -> Result<Option<Tensor>> {
        (gradient / x.elem_count() as f64)?.broadcast_as(x.shape())?.contiguous().map(Some)
    }
}

struct Dense;

impl CustomOp3 for Dense {
    fn name(&self) -> &'static str {
        "dense"
    }

    fn cpu_fwd(
        &self,
        x: &CpuStorage,
        rows: &Layout,
        weights: &CpuStorage,
        shape: &Layout,
        bias: &CpuStorage,
        outputs: &Layout,
    ) -> Result<(CpuStorage, Shape)> {
        let ((n, width), (inputs, to)) = (rows.shape().dims2()?, shape.shape().dims2()?);
        if width != inputs || outputs.dims() != [to] {
            bail!("rows of {width} values don't go through {inputs} × {to} weights and {:?}", outputs.dims());
        }
        let bias = elements(bias, outputs)?;
        let mut y: Vec<f32> = bias.iter().copied().cycle().take(n * to).collect();
        add_product(&mut y, Left::rows(elements(x, rows)?, inputs), elements(weights, shape)?, to);
        Ok((CpuStorage::F32(y), Shape::from((n, to))))
    }

    fn bwd(
        &self,
        x: &Tensor,
        weights: &Tensor,
        _: &Tensor,
        _: &Tensor,
        gradient: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>, Option<Tensor>)> {
        let ((n, inputs), outputs) = (x.dims2()?, weights.dim(1)?);
        let (x_values, gradients) = (numbers(x)?, numbers(gradient)?);
        let mut of_inputs = vec![0.0; n * inputs];
        add_product(&mut of_inputs, Left::rows(&gradients, outputs), &numbers(&weights.t()?)?, inputs);
        let mut of_weights = vec![0.0; inputs * outputs];
        add_product(&mut of_weights, Left::columns(&x_values, inputs), &gradients, outputs);
        let mut of_bias = vec![0.0; outputs];
        add_product(&mut of_bias, Left::rows(&vec![1.0; n], n), &gradients, outputs);
        let tensor = |values: Vec<f32>, like: Shape| Tensor::from_vec(values, like, x.device()).map(Some);
        Ok((
            tensor(of_inputs, (n, inputs).into())?,
            tensor(of_weights, (inputs, outputs).into())?,
            tensor(of_bias, outputs.into())?,
        ))
    }
}

/// The left matrix of a product: its elements, of which those of a row lie `along` apart, and rows `across`.
#[derive(Clone, Copy)]
struct Left<'a> {
    values: &'a [f32],
    across: usize,
    along: usize,
    length: usize,
}

impl<'a> Left<'a> {
    /// A matrix that lies row by row, each this wide.
    fn rows(values: &'a [f32], width: usize) -> Self {
        Self { values, across: width, along: 1, length: width }
    }

    /// The transpose of one.
    fn columns(values: &'a [f32], width: usize) -> Self {
        Self { values, across: 1, along: width, length: values.len() / width }
    }
}

/// Columns of a product that are added up at once.
const COLUMNS: usize = 32;

/// Adds the product of two matrices to a third; the right one and the third are so many columns wide. Each element is the sum of its
/// products in their order, however wide the processor's vectors are.
fn add_product(sums: &mut [f32], left: Left<'_>, right: &[f32], width: usize) {
    dispatch!(Level::new(), _simd => add_in_order(sums, left, right, width));
}

#[inline(always)]
fn add_in_order(sums: &mut [f32], left: Left<'_>, right: &[f32], width: usize) {
    for (row, sums) in sums.chunks_exact_mut(width).enumerate() {
        let own = left.values[row * left.across..].iter().step_by(left.along).take(left.length);
        let mut blocks = sums.chunks_exact_mut(COLUMNS);
        let mut first = 0;
        for block in &mut blocks {
            let mut sum: [f32; COLUMNS] = std::array::from_fn(|c| block[c]);
            for (factor, right) in own.clone().zip(right.chunks_exact(width)) {
                let right = &right[first..first + COLUMNS];
                for c in 0..COLUMNS {
                    sum[c] += factor * right[c];
                }
            }
            block.copy_from_slice(&sum);
            first += COLUMNS;
        }
        let rest = blocks.into_remainder();
        if !rest.is_empty() {
            for (factor, right) in own.zip(right.chunks_exact(width)) {
                for (sum, right) in rest.iter_mut().zip(&right[first..]) {
                    *sum += factor * right;
                }
            }
        }
    }
}

/// Values as a tensor of one column.
pub(crate) fn column(values: Vec<f32>) -> Result<Tensor> {
    let n = values.len();
    Tensor::from_vec(values, (n, 1), &Device::Cpu)
}

/// The elements of a tensor, row by row.
pub(crate) fn numbers(x: &Tensor) -> Result<Vec<f32>> {
    x.flatten_all()?.to_vec1()
}

/// The elements of a tensor that lies row by row.
fn elements<'a>(storage: &'a CpuStorage, layout: &Layout) -> Result<&'a [f32]> {
    match (storage, layout.contiguous_offsets()) {
        (CpuStorage::F32(values), Some((from, to))) => Ok(&values[from..to]),
        _ => bail!("not a tensor of single precision that lies row by row"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use candle_core::Var;
    use vb_math::rng::Stream;

    fn random(rows: usize, columns: usize, name: &str) -> Var {
        let mut random = Stream::new(5, &["test", name]);
        let values: Vec<f32> = (0..rows * columns).map(|_| random.normal(0.0, 1.0) as f32).collect();
        Var::from_vec(values, (rows, columns), &Device::Cpu).unwrap()
    }

    /// Holds value and gradients of a sum of squares against those of the same in candle's own operations.
    fn like_candle(inputs: &[&Var], own: &Tensor, candle: &Tensor) {
        let (own, candle) = (own.sqr().unwrap(), candle.sqr().unwrap());
        let gradients = [&own, &candle].map(|t| t.sum_all().unwrap().backward().unwrap());
        let near = |a: &Tensor, b: &Tensor| {
            let (a, b) = (numbers(a).unwrap(), numbers(b).unwrap());
            assert_eq!(a.len(), b.len());
            for (a, b) in a.iter().zip(&b) {
                assert!((a - b).abs() < 1e-4 * (1.0 + b.abs()), "{a} for {b}");
            }
        };
        near(&own, &candle);
        for input in inputs {
            near(gradients[0].get(input).unwrap(), gradients[1].get(input).unwrap());
        }
    }

    #[test]
    fn dense_layers_and_their_gradients_are_candles_but_for_rounding() {
        for (rows, inputs, outputs) in [(1, 1, 1), (5, 3, 2), (40, 60, 64), (7, 19, 33)] {
            let (x, w) = (random(rows, inputs, "x"), random(inputs, outputs, "w"));
            let b = Var::from_tensor(&random(1, outputs, "b").flatten_all().unwrap()).unwrap();
            let own = dense(&x, &w, &b).unwrap();
            like_candle(&[&x, &w, &b], &own, &x.matmul(&w).unwrap().broadcast_add(&b).unwrap());
        }
        let x = random(3, 4, "x");
        assert!(dense(&x, &random(5, 2, "w"), &Tensor::zeros(2, x.dtype(), x.device()).unwrap()).is_err());
    }

    #[test]
    fn functions_and_their_gradients_are_candles_but_for_rounding() {
        let x = random(6, 7, "x");
        like_candle(&[&x], &sin(&x).unwrap(), &x.sin().unwrap());
        like_candle(&[&x], &cos(&x).unwrap(), &x.cos().unwrap());
        like_candle(&[&x], &mean(&x).unwrap(), &x.mean_all().unwrap());
        let leak = x.maximum(&(x.as_tensor() * f64::from(LEAK)).unwrap()).unwrap();
        like_candle(&[&x], &rectify(&x).unwrap(), &leak);
        let soft = (x.exp().unwrap() + 1.0).unwrap().log().unwrap();
        like_candle(&[&x], &soft_plus(&x).unwrap(), &soft);
        let column = random(6, 1, "c");
        like_candle(&[&column], &widen(&column, 3).unwrap(), &column.broadcast_as((6, 3)).unwrap());
    }

    /// Of large logits neither the value nor the gradient overflows.
    #[test]
    fn a_soft_plus_of_a_large_number_is_that_number() {
        let x = Var::new(&[-200.0_f32, 0.0, 200.0], &Device::Cpu).unwrap();
        let y = soft_plus(&x).unwrap();
        assert_eq!(numbers(&y).unwrap(), [0.0, std::f32::consts::LN_2, 200.0]);
        let gradients = y.backward().unwrap();
        assert_eq!(numbers(gradients.get(&x).unwrap()).unwrap(), [0.0, 0.5, 1.0]);
    }

    /// The promise on which weights rest: the order of the sum does not depend on how many columns are summed at once.
    #[test]
    fn an_element_of_a_product_is_the_sum_of_its_products_in_their_order() {
        for (rows, length, width) in [(3, 50, 1), (4, 37, 31), (2, 384, 64), (3, 20, 70)] {
            let of = |rows, columns, name| numbers(&random(rows, columns, name)).unwrap();
            let (left, right) = (of(rows, length, "left"), of(length, width, "right"));
            let begun = of(rows, width, "begun");
            let mut own = begun.clone();
            add_product(&mut own, Left::rows(&left, length), &right, width);
            let mut turned = vec![0.0; left.len()];
            for (i, v) in left.iter().enumerate() {
                turned[i % length * rows + i / length] = *v;
            }
            let mut other = begun.clone();
            add_product(&mut other, Left::columns(&turned, rows), &right, width);
            for (i, begun) in begun.iter().enumerate() {
                let (row, column) = (i / width, i % width);
                let should = (0..length)
                    .fold(*begun, |sum, k| sum + left[row * length + k] * right[k * width + column]);
                assert_eq!(own[i].to_bits(), should.to_bits());
                assert_eq!(other[i].to_bits(), should.to_bits());
            }
        }
    }
}
