//! The tables of a scene as functions.

use leafwise_expression::TableFunction;

use super::Refusal;
use crate::document::SceneDocument;

/// The tables that formulas call, in the order of the text.
///
/// # Errors
/// A file that cannot be read, and numbers that make no table, underlined in the scene.
pub(super) fn tables(document: &SceneDocument) -> Result<Vec<TableFunction>, Refusal> {
    let tables = document.system.tables.iter().map(|(name, table)| {
        let function = table.function(&name.value, document.directory());
        function.map_err(|(place, reason)| {
            let has_numbers =
                table.numbers.is_some() || table.values.is_some() || table.file.is_some();
            let help = match has_numbers {
                true => {
                    "one number for each node, at equal distances along each axis: an array of NumPy's of the axes' nodes; \
                     for one axis also a column, for two a grid of CSV or JSON"
                        .to_owned()
                }
                false => format!(
                    "give its numbers, values = [...], or its file, file = \"{0}.npy\", or the array in Python: lw.Scene.parse(text, tables={{\"{0}\": array}})",
                    name.value
                ),
            };
            let label = if has_numbers { "here" } else { "no numbers" };
            Box::new(document.diagnostic(&place, reason, label, Some(help)))
        })
    });
    tables.collect()
}
