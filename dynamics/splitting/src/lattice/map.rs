//! Strang's product over pieces that repeat along a lattice.

use std::sync::Arc;

use leafwise_core::lattice::{
    Cells, Field, LatticeMap, LatticeProgram, LatticeSlopes, LatticeSource, PerAxis, Proxy,
    StageBuilder, Swept, TemplateReach,
};
use leafwise_core::solver::{Factored, MapAbilities, MapProperties, StepMap, Stepper, Structure};
use leafwise_core::{BuildError, Differential};
use leafwise_expression::syntax::AXES;
use leafwise_expression::{Arithmetic, Ring, StepSize};

use super::differential::SweptFlows;
use super::sweeps::{Shared, Sweeps};
use super::units::{find_repeating_pieces, looks};
use crate::code::flow_increment;
use crate::piece::{NAME, Piece};
use crate::probe::LONGEST;
use crate::product::{Product, Splits};
use crate::rounding::settled;
use crate::schedule::{Flow, STRANG, passes};

/// The most sites of a cell that are tried.
const LONGEST_PERIOD: usize = 4;

/// The same of one of twice the reach, where every term has its own place.
const FARTHEST_PERIOD: usize = 80;

/// A flow looks this many times further than its tensor and dH at most: its Lie series ends.
const FARTHEST: usize = LONGEST + 1;

/// [`Splitting`](crate::Splitting) of a lattice of any length: explicit, exactly Poisson, O(N) time
/// and memory a step. Each piece repeats every few sites (even and odd ones, say) and its flow is one
/// sweep, in place, over the sites that it moves.
#[derive(Clone, Debug)]
pub struct LatticeSplitting {
    pub(crate) shared: Arc<Shared>,
}

impl LatticeSplitting {
    /// Splits the Hamiltonian of a lattice on a proxy lattice. The proxy is just long enough for the templates.
    ///
    /// # Errors
    /// Fails with [`BuildError::DoesNotFit`] where no splitting repeats every four sites or fewer, or after twice its
    /// reach. Fails with it, too, where a ring's length is no multiple of the period. Fails with
    /// [`BuildError::NotLocal`] as for any long lattice, and with [`BuildError::Algebra`] where a formula is outside
    /// the algebra.
    pub fn new(source: &dyn LatticeSource) -> Result<Self, BuildError> {
        let geometry = source.geometry();
        let reach = source.reach()?;
        let mut misfits = Vec::new();
        // Terms that stand twice the reach apart have nothing to do with each other.
        let far = Some(reach.each()[0].saturating_mul(2));
        let far = far.filter(|period| (LONGEST_PERIOD + 1..=FARTHEST_PERIOD).contains(period));
        // Along several axes a cell is one site.
        let is_chain = geometry.axes.len() == 1;
        let periods = (1..=LONGEST_PERIOD).chain(far);
        for period in periods.take(if is_chain { usize::MAX } else { 1 }) {
            let Some(cells) = Cells::new(geometry.clone(), period) else {
                misfits.push(period);
                continue;
            };
            if let Some(splitting) = Self::with_cells(source, cells, &reach)? {
                return Ok(splitting);
            }
        }
        // Whether there is a splitting on a ring that is a little longer.
        let serves = |period: &usize| {
            let longer = geometry.length().next_multiple_of(*period);
            let cells = Cells::new(geometry.resized(&[longer]), *period);
            let found = cells.map(|cells| Self::with_cells(source, cells, &reach));
            matches!(found, Some(Ok(Some(_))))
        };
        let reason = match misfits.into_iter().find(serves) {
            Some(period) => format!(
                "its Hamiltonian does not split into pieces that repeat on a ring of {} sites; try a multiple of {period}",
                geometry.length()
            ),
            None if !is_chain => {
                "along several axes every piece repeats from site to site, and its Hamiltonian does not split into such pieces"
                    .to_owned()
            }
            None => format!(
                "its Hamiltonian does not split into pieces that repeat every {LONGEST_PERIOD} sites or fewer, \
                 or after twice the distance that it couples"
            ),
        };
        Err(BuildError::DoesNotFit { part: NAME, reason })
    }

    /// The splitting into pieces with the period of `cells`, if there is one.
    fn with_cells(
        source: &dyn LatticeSource,
        cells: Cells,
        reach: &TemplateReach,
    ) -> Result<Option<Self>, BuildError> {
        let ends = cells.sites().ends();
        let beside = std::array::from_fn(|axis| match ends[axis] {
            true => reach.beside[axis],
            false => 0,
        });
        let [once, beside] = [reach.of_times(1, ends), beside]
            .map(|sites: PerAxis<usize>| sites.map(|sites| sites.div_ceil(cells.period())));
        let mut looks = once;
        loop {
            match Self::on_proxy(source, &cells, cells.proxy(looks)?, (looks, beside))? {
                Found::Splitting(splitting) => return Ok(Some(*splitting)),
                Found::LooksFurther(cells)
                    if (0..AXES).all(|axis| cells[axis] <= FARTHEST * once[axis]) =>
                {
                    looks = std::array::from_fn(|axis| cells[axis].max(looks[axis]));
                }
                Found::None | Found::LooksFurther(_) => return Ok(None),
            }
        }
    }

    /// The splitting by code that is written on a proxy. The proxy has room for flows that look as far as `room`
    /// cells. At an open end that includes `beside` cells for what templates stand beside what they name.
    fn on_proxy(
        source: &dyn LatticeSource,
        cells: &Cells,
        (proxy_cells, width): (Cells, PerAxis<usize>),
        (room, beside): (PerAxis<usize>, PerAxis<usize>),
    ) -> Result<Found, BuildError> {
        let proxy = source.write_out(proxy_cells.sites())?;
        proxy.without_forces(NAME)?;
        let system = proxy.formulas(NAME)?;
        let mut ring = Ring::new(system.dimension());
        let Some(pieces) = find_repeating_pieces(source, &proxy_cells, system, &mut ring)? else {
            return Ok(Found::None);
        };
        if proxy_cells != *cells {
            let most = room.map(|room| FARTHEST * room);
            let mut farthest = [0; AXES];
            for piece in &pieces {
                let looks = looks(piece, &proxy_cells, &ring, most);
                farthest = std::array::from_fn(|axis| looks[axis].max(farthest[axis]));
            }
            let looks: PerAxis<usize> = std::array::from_fn(|axis| farthest[axis] + beside[axis]);
            if (0..AXES).any(|axis| looks[axis] > room[axis]) {
                return Ok(Found::LooksFurther(looks));
            }
        }
        let pieces = settled(system, &ring, pieces)?;
        let (builder, [state, sum]) = write_flows(&proxy_cells, &ring, &pieces)?;
        let (written, parameters) = (
            Proxy {
                geometry: proxy_cells.rows(),
                width,
            },
            system.parameters().len(),
        );
        let program = LatticeProgram::compile(cells.rows(), written, &builder, parameters)?;
        let program = Arc::new(program);
        let slopes = LatticeSlopes::new(&program, written, builder.without(sum), parameters);
        let mut order: Vec<usize> = (0..program.stages()).collect();
        order.sort_by_key(|stage| program.stage_work(*stage));
        Ok(Found::Splitting(Box::new(Self {
            shared: Arc::new(Shared {
                described: described(order.len(), cells.period()),
                structure: Structure::Exact,
                constants: Arc::default(),
                cells: cells.clone(),
                slopes: Arc::new(slopes),
                proxy_cells,
                program,
                state,
                sum,
                order,
            }),
        })))
    }

    /// The same with the pieces in this order.
    pub(crate) fn in_order(mut self, order: Vec<usize>) -> Self {
        Arc::make_mut(&mut self.shared).order = order;
        self
    }

    /// How many pieces there are.
    pub fn pieces(&self) -> usize {
        self.shared.order.len()
    }

    /// After how many sites the pieces repeat.
    pub fn period(&self) -> usize {
        self.shared.cells.period()
    }
}

fn described(pieces: usize, period: usize) -> String {
    let every = match period {
        1 => "site".to_owned(),
        period => format!("{period} sites"),
    };
    format!("{NAME} into {pieces} pieces that repeat every {every}")
}

/// Outcome of a search for pieces on a proxy.
enum Found {
    /// Pieces that repeat.
    Splitting(Box<LatticeSplitting>),
    /// None.
    None,
    /// Pieces with flows that look so many cells far along each axis, further than the proxy has room for.
    LooksFurther(PerAxis<usize>),
}

/// One stage for each piece: x ← x + δ and Σδ ← Σδ + δ, where the piece moves x.
fn write_flows(
    cells: &Cells,
    ring: &Ring,
    pieces: &[Piece],
) -> Result<(StageBuilder, [Field; 2]), BuildError> {
    let dimension = cells.rows().dimension();
    let mut builder = StageBuilder::new(dimension);
    let (state, values) = builder.unwritten();
    let (sum, sums) = builder.unwritten();
    let places: Vec<usize> = (0..dimension).map(|i| cells.place(i)).collect();
    let x: Vec<_> = places.iter().map(|place| values[*place].clone()).collect();
    let graph = &mut builder.graph;
    let (epsilon, h) = (
        graph.step_size(StepSize::Epsilon),
        graph.step_size(StepSize::H),
    );
    let time = graph.multiply(&epsilon, &h);
    for piece in pieces {
        let graph = &mut builder.graph;
        let increment = flow_increment(graph, ring, piece, &time, &x)?;
        let mut moved = vec![None; dimension];
        let mut added = vec![None; dimension];
        for (place, change) in places.iter().zip(increment) {
            if !graph.is_zero(&change) {
                moved[*place] = Some(graph.add(&values[*place], &change));
                added[*place] = Some(graph.add(&sums[*place], &change));
            }
        }
        builder.update(state, moved);
        builder.update(sum, added);
        builder.finish_stage();
    }
    Ok((builder, [state, sum]))
}

impl StepMap for LatticeSplitting {
    fn dimension(&self) -> usize {
        self.shared.cells.sites().dimension()
    }

    fn properties(&self) -> MapProperties {
        MapProperties {
            order: 2,
            structure: self.shared.structure,
            self_adjoint: Some(true),
        }
    }

    fn describe(&self) -> String {
        self.shared.described.clone()
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        self.passes_stepper(&STRANG, lanes, parameters, epsilon, h)
    }

    fn differential(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Differential> {
        self.passes_differential(&STRANG, parameters, epsilon, h)
    }

    fn abilities(&self) -> MapAbilities<'_> {
        MapAbilities {
            factored: Some(Factored {
                factors: Product::factors(self),
                pieces: self.pieces(),
                arranged: None,
                product: Box::new(|parts| Some(Arc::new(Product::new(self, parts)))),
            }),
            ..MapAbilities::default()
        }
    }
}

impl Splits for LatticeSplitting {
    fn passes_stepper(
        &self,
        parts: &[f64],
        lanes: usize,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Box<dyn Stepper> {
        let shared = Arc::clone(&self.shared);
        Box::new(Sweeps::new(shared, parts, lanes, parameters, epsilon, h))
    }

    fn passes_differential(
        &self,
        parts: &[f64],
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Box<dyn Differential> {
        let stepper = self.passes_stepper(parts, 1, parameters, epsilon, h);
        let (shared, sizes) = (Arc::clone(&self.shared), (epsilon, h));
        Box::new(SweptFlows::new(stepper, shared, parts, parameters, sizes))
    }
}

impl From<LatticeSplitting> for LatticeMap {
    fn from(splitting: LatticeSplitting) -> Self {
        let shared = &splitting.shared;
        let flows = passes(&shared.order, &STRANG);
        let operations = |flow: &Flow| shared.program.stage_operations(flow.piece);
        let work = |flow: &Flow| shared.program.stage_work(flow.piece);
        Self {
            geometry: shared.cells.sites().clone(),
            proxy_geometry: shared.proxy_cells.sites().clone(),
            operations: flows.iter().map(operations).sum(),
            work: flows.iter().map(work).sum(),
            fields: shared.program.fields(),
            swept: (splitting.period() == 1).then(|| Swept {
                program: Arc::clone(&shared.program),
                state: shared.state,
                sum: shared.sum,
                constants: Arc::clone(&shared.constants),
                order: shared.order.clone(),
            }),
            map: Arc::new(splitting),
        }
    }
}
