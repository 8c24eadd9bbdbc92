//! Families of sites, proxies, and the classes that share code.

/// Lattices of no more sites are written out as they are.
pub(super) const SHORTEST: usize = 9;

/// Families `x[0]` … `x[N-1]`, `a[0]` …, stored one after the other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LatticeGeometry {
    /// The families' names and lengths.
    pub families: Vec<(String, usize)>,
    /// Whether site N−1 is next to site 0.
    pub periodic: bool,
}

impl LatticeGeometry {
    /// The length of the longest family.
    pub fn length(&self) -> usize {
        self.families.iter().map(|f| f.1).max().unwrap_or(0)
    }

    /// The dimension of the state.
    pub fn dimension(&self) -> usize {
        self.families.iter().map(|f| f.1).sum()
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

    /// The same lattice with a longest family of `length` sites; families that were shorter by
    /// some sites stay so.
    pub fn resized(&self, length: usize) -> Self {
        let longest = self.length();
        let families = self
            .families
            .iter()
            .map(|(name, own)| (name.clone(), length.saturating_sub(longest - own)))
            .collect();
        Self {
            families,
            periodic: self.periodic,
        }
    }

    /// How many sites the shortest family lacks.
    fn lacking(&self) -> usize {
        let lengths = self.families.iter().map(|family| family.1);
        self.length() - lengths.min().unwrap_or(0)
    }

    /// Proxy lattice for code that looks at most `reach` sites away, and the number of sites at an open end that have
    /// code of their own there. Returns `None` where this lattice is no longer than the proxy.
    ///
    /// The interior code at a site looks at none beyond the end of a family.
    pub fn proxy(&self, reach: usize) -> Option<(Self, usize)> {
        let lacking = self.lacking();
        let width = reach.max(lacking).saturating_add(lacking);
        let length = width.saturating_mul(2).saturating_add(3);
        (length < self.length()).then(|| (self.resized(length), width))
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

    /// How far `site` is from `here`, the shorter way round on a ring.
    pub fn shift(&self, here: usize, site: usize) -> isize {
        let difference = site as isize - here as isize;
        if !self.periodic {
            return difference;
        }
        let length = self.length() as isize;
        (difference + length / 2).rem_euclid(length) - length / 2
    }

    /// The name of a coordinate, `x[3]`.
    pub fn name(&self, coordinate: usize) -> String {
        let (family, site) = self.locate(coordinate);
        format!("{}[{site}]", self.families[family].0)
    }
}

/// The proxy lattice code is written on.
#[derive(Clone, Copy, Debug)]
pub struct Proxy<'a> {
    /// The proxy; the true lattice itself where that is short.
    pub geometry: &'a LatticeGeometry,
    /// How many sites at an open boundary have code of their own, and how far code may look.
    pub width: usize,
}

/// Sites `start .. end` of the true lattice that share the code of one site of the proxy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SiteClass {
    pub(super) start: usize,
    pub(super) end: usize,
    pub(super) proxy: usize,
}

impl SiteClass {
    /// How many sites it has.
    pub(super) fn sites(self) -> usize {
        self.end - self.start
    }
}

/// The classes of a lattice of `length` sites on a proxy of `proxy` sites, `width` sites at each
/// open boundary having code of their own.
pub(super) fn site_classes(
    length: usize,
    proxy: usize,
    width: usize,
    periodic: bool,
) -> Vec<SiteClass> {
    if periodic {
        return vec![SiteClass {
            start: 0,
            end: length,
            proxy: proxy / 2,
        }];
    }
    if length == proxy {
        return (0..length)
            .map(|s| SiteClass {
                start: s,
                end: s + 1,
                proxy: s,
            })
            .collect();
    }
    let left = (0..width).map(|s| SiteClass {
        start: s,
        end: s + 1,
        proxy: s,
    });
    let interior = SiteClass {
        start: width,
        end: length - width,
        proxy: proxy / 2,
    };
    let right = (0..width).map(|k| SiteClass {
        start: length - width + k,
        end: length - width + k + 1,
        proxy: proxy - width + k,
    });
    left.chain(std::iter::once(interior)).chain(right).collect()
}
