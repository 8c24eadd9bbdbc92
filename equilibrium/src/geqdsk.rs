//! G-files of EFIT.

use crate::error::EquilibriumError;
use crate::tokens::Tokens;

/// The numbers of a g-file that make its field.
///
/// The form is that of L. Lao's EFIT. The first line has a title and the nodes along R and Z. Twenty numbers follow. Then F, p, FF′
/// and p′ stand at as many values of ψ as R has nodes, from the axis to the edge. Then come ψ at all nodes, those along R first,
/// and the safety factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Geqdsk {
    /// The title in the first line.
    pub title: String,
    /// The first and the last node along R, in m.
    pub r: [f64; 2],
    /// The first and the last node along Z, in m.
    pub z: [f64; 2],
    /// The nodes along R and Z.
    pub nodes: [usize; 2],
    /// R and Z of the magnetic axis as the file gives them, in m.
    pub axis: [f64; 2],
    /// ψ on the axis and at the edge, in Wb/rad.
    pub psi_range: [f64; 2],
    /// F = R B_φ at equal distances of ψ, from the axis to the edge, in T·m.
    pub f: Vec<f64>,
    /// ψ at the nodes, those along Z fastest, in Wb/rad.
    pub psi: Vec<f64>,
    /// The safety factor where F is, empty in files that end before it.
    pub q: Vec<f64>,
}

/// Most nodes of a grid.
const MOST_NODES: usize = 1 << 24;

impl Geqdsk {
    /// Reads a g-file.
    ///
    /// # Errors
    /// [`EquilibriumError`] with the line or the quantity where the text is none.
    pub fn parse(text: &str) -> Result<Self, EquilibriumError> {
        let first = text.lines().next().unwrap_or_default();
        let (title, [along_r, along_z]) = header(first)?;
        if along_r.saturating_mul(along_z) > MOST_NODES {
            let message = format!("{along_r} × {along_z} nodes are too many");
            return Err(EquilibriumError::Odd(message));
        }
        let mut tokens = Tokens::of(text, 1);
        let numbers = tokens.numbers("the twenty numbers after the first line", 20)?;
        let [width, height, _, left, middle] = first_of(&numbers);
        let axis = [numbers[5], numbers[6]];
        let psi_range = [numbers[7], numbers[8]];
        let f = tokens.numbers("F = R B_phi", along_r)?;
        for name in ["the pressure", "FF'", "p'"] {
            tokens.numbers(name, along_r)?;
        }
        let rows = tokens.numbers("the flux psi(R, Z)", along_r * along_z)?;
        let q = match tokens.is_at_end() {
            true => Vec::new(),
            false => tokens.numbers("the safety factor", along_r)?,
        };
        let psi = (0..along_r).flat_map(|i| (0..along_z).map(move |j| (i, j)));
        let file = Self {
            title,
            r: [left, left + width],
            z: [middle - height / 2.0, middle + height / 2.0],
            nodes: [along_r, along_z],
            axis,
            psi_range,
            f,
            psi: psi.map(|(i, j)| rows[j * along_r + i]).collect(),
            q,
        };
        file.check()?;
        Ok(file)
    }

    fn check(&self) -> Result<(), EquilibriumError> {
        let odd = |message: String| Err(EquilibriumError::Odd(message));
        let [left, right] = self.r;
        if !(left > 0.0 && right > left) {
            return odd(format!(
                "R goes from {left} to {right}: a grid must lie to one side of the axis R = 0"
            ));
        }
        let [low, high] = self.z;
        if high <= low || high.is_nan() {
            return odd(format!("Z goes from {low} to {high}"));
        }
        if self.psi_range[0] == self.psi_range[1] {
            return odd(format!(
                "the flux is {} on the axis and at the edge",
                self.psi_range[0]
            ));
        }
        let count = self.f.len();
        let changes = |at: &usize| {
            self.f
                .get(at + 1)
                .is_some_and(|next| self.f[*at] * next < 0.0)
        };
        let vanishing = (0..count).find(|at| self.f[*at] == 0.0 || changes(at));
        vanishing.map_or(Ok(()), |at| {
            Err(EquilibriumError::NoToroidalField {
                node: at + 1,
                count,
                surface: at as f64 / (count - 1) as f64,
                f: self.f[at],
            })
        })
    }
}

/// The nodes of three numbers in four places each behind the title's.
fn behind_title(line: &str, count: impl Fn(&str) -> Option<usize>) -> Option<[usize; 2]> {
    let place = |at: usize| line.get(TITLE + 4 * at..TITLE + 4 * (at + 1));
    let is_alone = line
        .get(TITLE + 12..)
        .is_none_or(|rest| !rest.starts_with(|c: char| c.is_ascii_digit()));
    place(0)?.trim().parse::<i64>().ok()?;
    let nodes = [count(place(1)?)?, count(place(2)?)?];
    is_alone.then_some(nodes)
}

/// The last two of the last three whole numbers that follow each other, between spaces.
fn in_a_row(line: &str, count: impl Fn(&str) -> Option<usize>) -> Option<[usize; 2]> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let mut threes = words.windows(3).rev();
    threes.find_map(|three| {
        three[0].parse::<i64>().ok()?;
        let nodes = [count(three[1])?, count(three[2])?];
        nodes.iter().all(|count| *count >= LEAST).then_some(nodes)
    })
}

/// Nodes of a grid between other whole numbers, at least.
const LEAST: usize = 10;

/// The first five numbers.
fn first_of(numbers: &[f64]) -> [f64; 5] {
    std::array::from_fn(|at| numbers[at])
}

/// Places of the title in the first line, before three whole numbers of four places each: one without meaning, and the nodes.
const TITLE: usize = 48;

/// The title and the nodes: whole numbers at the end of the first line, between spaces or of four places each. Some programs write a
/// text behind them: then they are those behind the title's places, or the last two of three in a row.
fn header(line: &str) -> Result<(String, [usize; 2]), EquilibriumError> {
    let count = |word: &str| {
        word.trim()
            .parse::<usize>()
            .ok()
            .filter(|count| *count >= 2)
    };
    let mut words = line.split_whitespace().rev();
    let spaced = [words.next(), words.next()].map(|word| word.and_then(count));
    let fixed = || {
        let end = line.trim_end();
        let (rest, last) = end.split_at_checked(end.len().checked_sub(4)?)?;
        let (_, first) = rest.split_at_checked(rest.len().checked_sub(4)?)?;
        Some([count(first)?, count(last)?])
    };
    let at_end = || match spaced {
        [Some(z), Some(r)] if line.split_whitespace().count() > 2 && r < 10_000 && z < 10_000 => {
            Some([r, z])
        }
        _ => None,
    };
    let nodes = behind_title(line, count).or_else(at_end);
    let nodes = nodes.or_else(|| in_a_row(line, count)).or_else(fixed);
    let title: String = line.chars().take(48).collect();
    let nodes = nodes.ok_or(EquilibriumError::Header)?;
    Ok((
        title.split_whitespace().collect::<Vec<_>>().join(" "),
        nodes,
    ))
}
