//! Words for `twinhub explain`.

/// What can be said about one entry of the registry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Explanation {
    /// Name in the registry.
    pub name: &'static str,
    /// What it claims.
    pub claim: &'static str,
    /// Its equation.
    pub equation: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// Where it holds.
    pub valid_for: &'static str,
}

/// The explanation of the entry called `name`.
pub fn explain(name: &str) -> Option<&'static Explanation> {
    EXPLANATIONS.iter().find(|entry| entry.name == name)
}

const EXPLANATIONS: &[Explanation] = &[];
