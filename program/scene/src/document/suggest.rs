//! The nearest valid name.

/// Candidate nearest to `name`, if one is near enough to be a likely misspelling. At most a third of the longer name's
/// letters then differ; one letter of two or more always may. A candidate is near too where one name begins with the
/// other.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let folded = fold(name);
    candidates
        .into_iter()
        .filter_map(|candidate| {
            let other = fold(candidate);
            let distance = strsim::damerau_levenshtein(&folded, &other);
            let longest = folded.chars().count().max(other.chars().count());
            let prefix = folded.len().min(other.len()) >= 3
                && (folded.starts_with(&other) || other.starts_with(&folded));
            // Of a single letter nothing is left when it is another one.
            let is_near = distance <= (longest / 3).max(1) && distance < longest;
            (is_near || prefix).then_some((distance, candidate))
        })
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate.to_owned())
}

/// Letter case and the choice between `-`, `_` and a space do not count as differences.
fn fold(name: &str) -> String {
    name.to_lowercase().replace(['_', ' '], "-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelling_finds_its_name_and_a_stranger_does_not() {
        let names = ["epsilon", "h", "time-step"];
        assert_eq!(nearest("epsillon", names).as_deref(), Some("epsilon"));
        assert_eq!(nearest("time_step", names).as_deref(), Some("time-step"));
        assert_eq!(nearest("casimirs", names), None);
        assert_eq!(nearest("e", ["q", "p"]), None);
        assert_eq!(nearest("Q", ["q", "p"]).as_deref(), Some("q"));
    }
}
