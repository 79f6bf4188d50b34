//! The catalogue as a VOTable 1.4 (IVOA recommendation of 2019), its cells as text.

use super::{Catalogue, Value, text::json_of};
use crate::write::Entry;
use std::io::{self, Write};

/// Writes the table with units, descriptions and UCDs; an empty cell where there is no value.
pub fn write(catalogue: &Catalogue, entries: &[Entry], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>")?;
    writeln!(out, "<VOTABLE version=\"1.4\" xmlns=\"http://www.ivoa.net/xml/VOTable/v1.3\">")?;
    writeln!(out, "<RESOURCE type=\"results\">\n<TABLE name=\"CATALOG\">")?;
    for entry in entries {
        if let Entry::Key(keyword, value, comment) = entry {
            let text = json_of(value).as_str().map_or_else(|| value.to_string(), str::to_owned);
            let (name, value) = (escaped(keyword), escaped(&text));
            let kind = "datatype=\"char\" arraysize=\"*\"";
            writeln!(out, "<PARAM name=\"{name}\" {kind} value=\"{value}\">")?;
            writeln!(out, "<DESCRIPTION>{}</DESCRIPTION>\n</PARAM>", escaped(comment))?;
        }
    }
    for column in &catalogue.columns {
        let kind = if matches!(column.value, Value::Integer(_)) { "long" } else { "double" };
        let attribute = |name: &str, value: &str| match value {
            "" => String::new(),
            value => format!(" {name}=\"{}\"", escaped(value)),
        };
        let (unit, ucd) = (attribute("unit", &column.unit), attribute("ucd", column.ucd()));
        writeln!(out, "<FIELD name=\"{}\" datatype=\"{kind}\"{unit}{ucd}>", escaped(&column.name))?;
        writeln!(out, "<DESCRIPTION>{}</DESCRIPTION>\n</FIELD>", escaped(&column.description))?;
    }
    writeln!(out, "<DATA>\n<TABLEDATA>")?;
    for source in &catalogue.rows {
        let cells: String =
            catalogue.columns.iter().map(|column| format!("<TD>{}</TD>", column.text(source))).collect();
        writeln!(out, "<TR>{cells}</TR>")?;
    }
    writeln!(out, "</TABLEDATA>\n</DATA>\n</TABLE>\n</RESOURCE>\n</VOTABLE>")
}

/// Text as XML allows it.
fn escaped(text: &str) -> String {
    let entity = |c: char| match c {
        '&' => "&amp;".to_owned(),
        '<' => "&lt;".to_owned(),
        '>' => "&gt;".to_owned(),
        '"' => "&quot;".to_owned(),
        c if c.is_control() => format!("\\u{{{:x}}}", u32::from(c)),
        c => c.to_string(),
    };
    text.chars().map(entity).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_in_a_text_is_none() {
        assert_eq!(escaped("a<b> & \"c\"\n"), "a&lt;b&gt; &amp; &quot;c&quot;\\u{a}");
    }
}
