//! One function at a few points, in every layout, with canaries around its output.

use leafwise_plugin_abi::LwMapFn;

use crate::foreign::{Call, CallFailure, Input, Instance, Output, is_unwritten, unwritten};
use crate::smoke_failure::SmokeFailure;

/// Numbers between and around results, which nothing may change.
const GAP: usize = 3;

/// A function with what it takes and gives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Function<'a> {
    pub name: &'a str,
    pub function: LwMapFn,
    /// Numbers of a result.
    pub results: usize,
    pub epsilon: f64,
    pub h: f64,
}

/// Points of a batch with up to two vectors each; all of one length.
#[derive(Clone, Debug, Default)]
pub(super) struct Points {
    pub point: Vec<Vec<f64>>,
    pub v: Vec<Vec<f64>>,
    pub w: Vec<Vec<f64>>,
}

impl Points {
    /// One of the points with its vectors.
    pub(super) fn alone(&self, at: usize) -> Self {
        self.in_order(&[at])
    }

    /// The points of these places, one after the other.
    pub(super) fn in_order(&self, places: &[usize]) -> Self {
        let chosen = |vectors: &Vec<Vec<f64>>| -> Vec<Vec<f64>> {
            let places = places.iter();
            places.filter_map(|at| vectors.get(*at).cloned()).collect()
        };
        Self {
            point: chosen(&self.point),
            v: chosen(&self.v),
            w: chosen(&self.w),
        }
    }

    /// Points without vectors.
    pub(super) fn of(point: Vec<Vec<f64>>) -> Self {
        Self {
            point,
            ..Self::default()
        }
    }
}

/// How a batch lies in memory.
#[derive(Clone, Copy, Debug)]
enum Layout {
    /// Points with gaps between them.
    Points,
    /// A structure of arrays, with gaps.
    Lanes,
}

impl Layout {
    /// Strides of points and coordinates.
    fn strides(self, count: usize, dim: usize) -> (usize, usize) {
        match self {
            Self::Points => (dim + GAP, 1),
            Self::Lanes => (1, count + GAP),
        }
    }

    fn write(self, vectors: &[Vec<f64>]) -> Vec<f64> {
        let dim = vectors.first().map_or(0, Vec::len);
        let (point, coordinate) = self.strides(vectors.len(), dim);
        let mut data = vec![unwritten(); size(vectors.len(), dim, point, coordinate)];
        for (i, vector) in vectors.iter().enumerate() {
            for (j, value) in vector.iter().enumerate() {
                data[i * point + j * coordinate] = *value;
            }
        }
        data
    }

    fn input<'a>(self, data: &'a [f64], vectors: &[Vec<f64>]) -> Input<'a> {
        match vectors.first() {
            None => Input::NONE,
            Some(first) => {
                let (point, coordinate) = self.strides(vectors.len(), first.len());
                Input::strided(data, first.len(), point, coordinate)
            }
        }
    }
}

fn size(count: usize, dim: usize, point: usize, coordinate: usize) -> usize {
    count * point.max(1) + dim * coordinate.max(1) + GAP
}

impl Function<'_> {
    /// Calls the function on `instance` and checks its answers. They must be finite, repeatable, the same in every
    /// layout and alone; nothing else may have been written. The result is `None` where the points are outside its
    /// domain, or the instance does not offer it.
    pub(super) fn checked(
        &self,
        instance: &mut Instance,
        points: &Points,
    ) -> Result<Option<Vec<Vec<f64>>>, SmokeFailure> {
        let Some(first) = self.call(instance, points, Layout::Points)? else {
            return Ok(None);
        };
        let again = self.call(instance, points, Layout::Points)?;
        if !again.is_some_and(|again| again.iter().zip(&first).all(|(a, b)| same(a, b))) {
            return Err(SmokeFailure::NotRepeatable {
                function: self.name.to_owned(),
            });
        }
        let differs = |point: usize| SmokeFailure::BatchDiffers {
            function: self.name.to_owned(),
            point,
        };
        let lanes = self
            .call(instance, points, Layout::Lanes)?
            .ok_or_else(|| differs(0))?;
        for (at, answer) in first.iter().enumerate() {
            let alone = self.call(instance, &points.alone(at), Layout::Points)?;
            let is_same = alone.is_some_and(|alone| same(&alone[0], answer));
            if !is_same || !same(&lanes[at], answer) {
                return Err(differs(at));
            }
        }
        Ok(Some(first))
    }

    /// One call at contiguous points; `None` where they are outside the function's domain, or
    /// the instance does not offer it.
    pub(super) fn once(
        &self,
        instance: &mut Instance,
        points: &Points,
    ) -> Result<Option<Vec<Vec<f64>>>, SmokeFailure> {
        self.call(instance, points, Layout::Points)
    }

    fn call(
        &self,
        instance: &mut Instance,
        points: &Points,
        layout: Layout,
    ) -> Result<Option<Vec<Vec<f64>>>, SmokeFailure> {
        let (count, dim) = (points.point.len(), self.results);
        let data = [&points.point, &points.v, &points.w].map(|vectors| layout.write(vectors));
        let call = Call {
            v: layout.input(&data[1], &points.v),
            w: layout.input(&data[2], &points.w),
            ..Call::at(
                count,
                self.epsilon,
                self.h,
                layout.input(&data[0], &points.point),
            )
        };
        let (point, coordinate) = layout.strides(count, dim);
        let mut output = vec![unwritten(); GAP + size(count, dim, point, coordinate)];
        let inside = Output::strided(&mut output[GAP..], dim, point, coordinate);
        let outcome = instance.evaluate(self.function, &call, inside);
        let place = |i: usize, j: usize| GAP + i * point + j * coordinate;
        let mut is_result = vec![false; output.len()];
        (0..count).for_each(|i| (0..dim).for_each(|j| is_result[place(i, j)] = true));
        let written = |at: &usize| !is_result[*at] && !is_unwritten(output[*at]);
        if let Some(at) = (0..output.len()).find(written) {
            let last = is_result.iter().rposition(|is| *is).unwrap_or(0);
            return Err(SmokeFailure::Overwritten {
                function: self.name.to_owned(),
                where_to: if at > last {
                    "past the end of its output".to_owned()
                } else if at < GAP {
                    "before its output".to_owned()
                } else {
                    "into the gaps between its results".to_owned()
                },
            });
        }
        // What a library writes there the compiler does not know of.
        let [point, v, w] = std::hint::black_box(data);
        let vectors = [("point", point), ("v", v), ("w", w)];
        let given = [&points.point, &points.v, &points.w].map(|vectors| layout.write(vectors));
        if let Some(((input, _), _)) = vectors.iter().zip(&given).find(|((_, a), b)| !same(a, b)) {
            return Err(SmokeFailure::Overwritten {
                function: self.name.to_owned(),
                where_to: format!("to its input `{input}`"),
            });
        }
        match outcome {
            Ok(()) => Ok(Some(
                (0..count)
                    .map(|i| (0..dim).map(|j| output[place(i, j)]).collect())
                    .collect(),
            )),
            Err(CallFailure::Discarded { .. } | CallFailure::Unsupported { .. }) => Ok(None),
            Err(CallFailure::NotFinite { point, coordinate }) => Err(SmokeFailure::NotFinite {
                function: self.name.to_owned(),
                point,
                coordinate,
            }),
            Err(CallFailure::Unwritten { point, coordinate }) => Err(SmokeFailure::Unwritten {
                function: self.name.to_owned(),
                point,
                coordinate,
            }),
            Err(failure) => Err(SmokeFailure::Call {
                function: self.name.to_owned(),
                message: failure.to_string(),
            }),
        }
    }
}

/// Whether two vectors have the same bits.
pub(super) fn same(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}
