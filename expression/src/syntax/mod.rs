//! Scene formulas: text with byte spans, names resolved in a scope.
