//! What a registry entry tells a user who asks about it.

/// The answer of `twinhub explain NAME`, in the order of a model file's head.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Explain {
    /// Name in the registry and in TOML.
    pub name: &'static str,
    /// What it models.
    pub what: &'static str,
    /// The equations, in words and symbols.
    pub equation: &'static str,
    /// Where equations and figures come from, guesses marked as such.
    pub source: &'static str,
    /// What it assumes and what it leaves out.
    pub assumes: &'static str,
}

impl core::fmt::Display for Explain {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        writeln!(f, "{}: {}", self.name, self.what)?;
        writeln!(f, "Equation: {}", self.equation)?;
        writeln!(f, "Source: {}", self.source)?;
        write!(f, "Assumes and ignores: {}", self.assumes)
    }
}

#[cfg(test)]
impl Explain {
    /// Every part says something.
    pub(crate) fn is_complete(&self) -> bool {
        [
            self.name,
            self.what,
            self.equation,
            self.source,
            self.assumes,
        ]
        .iter()
        .all(|t| t.len() > 2)
    }
}
