//! Families of sites along axes, proxies, and the classes that share code.

use std::ops::Range;

use leafwise_expression::syntax::{AXES, SiteNames};

/// Lattices of no more sites are written out as they are.
pub(super) const SHORTEST: usize = 9;

/// A number an axis; axes that a lattice does not have are not looked at.
pub type PerAxis<T> = [T; AXES];

/// One axis of a lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axis {
    /// The number of its sites.
    pub length: usize,
    /// Whether its last site is next to its first.
    pub periodic: bool,
}

/// Families `x[0]` … `x[N-1]`, `a[0]` … along one axis, or `s[0,0]` … along several, stored one after the other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LatticeGeometry {
    /// The families' names and numbers of sites; along several axes all have the same.
    pub families: Vec<(String, usize)>,
    /// The axes, from 1 to [`AXES`]; sites are numbered along the last one first.
    pub axes: Vec<Axis>,
    /// Names of the sites of a chain; none where they are numbers.
    pub site_names: SiteNames,
}

impl LatticeGeometry {
    /// Families along one axis, as long as the longest of them.
    pub fn chain(families: Vec<(String, usize)>, periodic: bool) -> Self {
        let length = families.iter().map(|family| family.1).max().unwrap_or(0);
        Self {
            families,
            axes: vec![Axis { length, periodic }],
            site_names: SiteNames::default(),
        }
    }

    /// The same lattice with names of its sites.
    pub fn with_site_names(self, site_names: SiteNames) -> Self {
        Self { site_names, ..self }
    }

    /// Families of these names with a member at each site of the axes.
    pub fn along(names: impl IntoIterator<Item = String>, axes: Vec<Axis>) -> Self {
        let sites = axes.iter().map(|axis| axis.length).product();
        Self {
            families: names.into_iter().map(|name| (name, sites)).collect(),
            axes,
            site_names: SiteNames::default(),
        }
    }

    /// The number of sites: those of the longest family.
    pub fn length(&self) -> usize {
        self.axes.iter().map(|axis| axis.length).product()
    }

    /// The length of each axis.
    pub fn lengths(&self) -> Vec<usize> {
        self.axes.iter().map(|axis| axis.length).collect()
    }

    /// The dimension of the state.
    pub fn dimension(&self) -> usize {
        self.families.iter().map(|f| f.1).sum()
    }

    /// Whether no axis has ends.
    pub fn is_periodic(&self) -> bool {
        self.axes.iter().all(|axis| axis.periodic)
    }

    /// Along which axes there are ends.
    pub fn ends(&self) -> PerAxis<bool> {
        std::array::from_fn(|axis| self.axes.get(axis).is_some_and(|axis| !axis.periodic))
    }

    /// Where each family starts in the state.
    pub fn offsets(&self) -> Vec<usize> {
        self.families
            .iter()
            .scan(0, |next, f| {
                let start = *next;
                *next += f.1;
                Some(start)
            })
            .collect()
    }

    /// The same lattice with axes of other lengths, its sites without names. Along one axis families that were shorter by some sites stay so.
    pub fn resized(&self, lengths: &[usize]) -> Self {
        let mut axes = self.axes.clone();
        for (axis, length) in axes.iter_mut().zip(lengths) {
            axis.length = *length;
        }
        let (sites, longest) = (axes.iter().map(|axis| axis.length).product(), self.length());
        let own = |own: usize| match axes.len() {
            1 => usize::saturating_sub(sites, longest - own),
            _ => sites,
        };
        let families = self.families.iter();
        Self {
            families: families
                .map(|(name, sites)| (name.clone(), own(*sites)))
                .collect(),
            axes,
            site_names: SiteNames::default(),
        }
    }

    /// The lattice of some of its families; along one axis it is as long as the longest of them.
    pub fn of_families(&self, families: impl IntoIterator<Item = usize>) -> Self {
        let families = families.into_iter().map(|at| self.families[at].clone());
        match self.axes[..] {
            [axis] => {
                let chain = Self::chain(families.collect(), axis.periodic);
                chain.with_site_names(self.site_names.clone())
            }
            _ => Self {
                families: families.collect(),
                ..self.clone()
            },
        }
    }

    /// How many sites the shortest family lacks.
    fn lacking(&self) -> usize {
        let lengths = self.families.iter().map(|family| family.1);
        self.length() - lengths.min().unwrap_or(0)
    }

    /// Proxy lattice for code that looks at most `reach` sites away along each axis, and the number of sites at an open
    /// end that have code of their own there. Returns `None` where this lattice is no longer than the proxy along any
    /// axis.
    ///
    /// The interior code at a site looks at none beyond the end of a family.
    pub fn proxy(&self, reach: PerAxis<usize>) -> Option<(Self, PerAxis<usize>)> {
        let lacking = self.lacking();
        let width = reach.map(|reach| reach.max(lacking).saturating_add(lacking));
        let lengths = self.axes.iter().zip(width).map(|(axis, width)| {
            let length = width.saturating_mul(2).saturating_add(3);
            axis.length.min(length)
        });
        let lengths: Vec<usize> = lengths.collect();
        (lengths != self.lengths()).then(|| (self.resized(&lengths), width))
    }

    /// Family and site of a coordinate.
    pub fn locate(&self, coordinate: usize) -> (usize, usize) {
        let mut rest = coordinate;
        for (family, (_, length)) in self.families.iter().enumerate() {
            if rest < *length {
                return (family, rest);
            }
            rest -= length;
        }
        unreachable!("a coordinate lies in one of the families")
    }

    /// Place of a site along each axis.
    pub fn place(&self, site: usize) -> PerAxis<usize> {
        let (mut place, mut rest) = ([0; AXES], site);
        for (axis, own) in self.axes.iter().enumerate().rev() {
            place[axis] = match axis {
                0 => rest,
                _ => rest % own.length.max(1),
            };
            rest /= own.length.max(1);
        }
        place
    }

    /// Number of the site at a place.
    pub fn site(&self, place: PerAxis<usize>) -> usize {
        let axes = self.axes.iter().zip(place);
        axes.fold(0, |site, (axis, at)| site * axis.length + at)
    }

    /// The site in the middle of every axis.
    pub fn middle(&self) -> usize {
        let middle = |axis: usize| self.axes.get(axis).map_or(0, |axis| axis.length / 2);
        self.site(std::array::from_fn(middle))
    }

    /// How far `site` is from `here` along each axis, the shorter way round where it is periodic.
    pub fn shift(&self, here: usize, site: usize) -> PerAxis<isize> {
        let (here, place) = (self.place(here), self.place(site));
        std::array::from_fn(|at| {
            let difference = place[at] as isize - here[at] as isize;
            let Some(axis) = self.axes.get(at).filter(|axis| axis.periodic) else {
                return difference;
            };
            let length = axis.length as isize;
            (difference + length / 2).rem_euclid(length) - length / 2
        })
    }

    /// The site that is so far from `here`; `None` beyond an end.
    pub fn beside(&self, here: usize, shift: PerAxis<isize>) -> Option<usize> {
        let mut place = self.place(here);
        for ((axis, at), shift) in self.axes.iter().zip(&mut place).zip(shift) {
            *at = axis.beside(*at, shift)?;
        }
        Some(self.site(place))
    }

    /// How far apart in memory sites are that stand so far from each other, where no axis closes between them.
    pub(super) fn distance(&self, shift: PerAxis<isize>) -> isize {
        let axes = self.axes.iter().zip(shift);
        axes.fold(0, |distance, (axis, shift)| {
            distance * axis.length as isize + shift
        })
    }

    /// The name of a coordinate, `x[3]` or `s[0,7]`.
    pub fn name(&self, coordinate: usize) -> String {
        let (family, site) = self.locate(coordinate);
        format!("{}[{}]", self.families[family].0, self.site_name(site))
    }

    /// The place of a site as it is written in brackets: `3`, `0,7` or the site's name.
    pub fn site_name(&self, site: usize) -> String {
        if !self.site_names.is_empty() {
            return self.site_names.name(site);
        }
        let place = &self.place(site)[..self.axes.len()];
        let place: Vec<String> = place.iter().map(usize::to_string).collect();
        place.join(",")
    }
}

impl Axis {
    /// The place so far from `at`; `None` beyond an end.
    fn beside(self, at: usize, shift: isize) -> Option<usize> {
        let place = at as isize + shift;
        match self.periodic {
            true => Some(place.rem_euclid(self.length.max(1) as isize) as usize),
            false => usize::try_from(place).ok().filter(|at| *at < self.length),
        }
    }

    /// The ranges of places that share the code of one place of a proxy axis, and that place.
    fn classes(self, proxy: usize, width: usize) -> Vec<(Range<usize>, usize)> {
        let length = self.length;
        if self.periodic {
            return vec![(0..length, proxy / 2)];
        }
        if length == proxy {
            return (0..length).map(|at| (at..at + 1, at)).collect();
        }
        let left = (0..width).map(|at| (at..at + 1, at));
        let interior = (width..length - width, proxy / 2);
        let right = (0..width).map(|at| {
            let own = length - width + at;
            (own..own + 1, proxy - width + at)
        });
        left.chain([interior]).chain(right).collect()
    }
}

/// The proxy lattice code is written on.
#[derive(Clone, Copy, Debug)]
pub struct Proxy<'a> {
    /// The proxy; the true lattice itself where that is short.
    pub geometry: &'a LatticeGeometry,
    /// How many sites at an open boundary have code of their own along each axis, and how far code may look.
    pub width: PerAxis<usize>,
}

/// Sites of a box, those at places from `start` to before `end` along each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SiteBox {
    pub(super) start: PerAxis<usize>,
    pub(super) end: PerAxis<usize>,
}

impl SiteBox {
    /// How many sites it has.
    pub(super) fn sites(&self) -> usize {
        let lengths = self.start.iter().zip(&self.end);
        lengths
            .map(|(start, end)| end.saturating_sub(*start))
            .product()
    }

    /// Its sites in ranges, one for each of its rows along the last axis; of whole rows one range.
    pub(super) fn runs(
        &self,
        geometry: &LatticeGeometry,
    ) -> impl Iterator<Item = Range<usize>> + use<> {
        let axes = geometry.axes.len();
        // From this axis on the box is as long as the lattice.
        let is_whole =
            |axis: &usize| (self.start[*axis], self.end[*axis]) == (0, geometry.axes[*axis].length);
        let whole = (0..axes).rev().take_while(is_whole).count();
        let (mut rows, mut length) = (*self, 1);
        let along = axes - whole.min(axes.saturating_sub(1));
        for axis in along..axes {
            length *= geometry.axes[axis].length;
            rows.end[axis] = rows.start[axis] + 1;
        }
        let (places, of_row) = rows.rows(along);
        let starts: Vec<usize> = places.map(|place| geometry.site(place)).collect();
        starts
            .into_iter()
            .map(move |start| start..start + of_row * length)
    }

    /// Whether a place lies in it.
    pub(super) fn has(&self, place: PerAxis<usize>) -> bool {
        (0..AXES).all(|axis| (self.start[axis]..self.end[axis]).contains(&place[axis]))
    }

    /// The places where its rows along the last of `axes` axes begin, in the order of their sites, and their length.
    pub(super) fn rows(
        &self,
        axes: usize,
    ) -> (impl Iterator<Item = PerAxis<usize>> + use<>, usize) {
        let Self { start, end } = *self;
        let last = axes.saturating_sub(1);
        let length = end[last].saturating_sub(start[last]);
        let counts: PerAxis<usize> = std::array::from_fn(|axis| match axis == last {
            true => 1,
            false => end[axis].saturating_sub(start[axis]),
        });
        let rows = if length == 0 {
            0
        } else {
            counts.iter().product()
        };
        let place = move |row: usize| {
            let (mut place, mut rest) = (start, row);
            for axis in (0..AXES).rev() {
                place[axis] += rest % counts[axis].max(1);
                rest /= counts[axis].max(1);
            }
            place
        };
        ((0..rows).map(place), length)
    }
}

/// Sites of the true lattice that share the code of one site of the proxy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SiteClass {
    pub(super) sites: SiteBox,
    pub(super) proxy: usize,
}

impl SiteClass {
    /// How many sites it has.
    pub(super) fn sites(&self) -> usize {
        self.sites.sites()
    }
}

/// The classes of a lattice that is written on a proxy.
pub(super) fn site_classes(geometry: &LatticeGeometry, proxy: Proxy<'_>) -> Vec<SiteClass> {
    let whole = SiteBox {
        start: [0; AXES],
        end: [1; AXES],
    };
    let mut classes = vec![(whole, [0; AXES])];
    for (at, axis) in geometry.axes.iter().enumerate() {
        let own = axis.classes(proxy.geometry.axes[at].length, proxy.width[at]);
        let each = classes.into_iter().flat_map(|(sites, place)| {
            own.iter().map(move |(range, of_proxy)| {
                let (mut sites, mut place) = (sites, place);
                (sites.start[at], sites.end[at]) = (range.start, range.end);
                place[at] = *of_proxy;
                (sites, place)
            })
        });
        classes = each.collect();
    }
    let class = |(sites, place)| SiteClass {
        sites,
        proxy: proxy.geometry.site(place),
    };
    classes.into_iter().map(class).collect()
}
