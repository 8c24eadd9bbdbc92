//! Numbers of things in words.

/// 1 step, 2 steps: for nouns whose plural takes an s.
pub fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{plural}")
}
