//! report.html: one self-contained page with the image, its outlines, the catalogue and the making.
//!
//! Nothing is loaded from elsewhere; a content security policy in the page forbids it. The page
//! draws everything from one JSON object, which `data` makes.

mod data;
mod picture;
mod places;

pub use data::{Subject, page_data};

use serde_json::Value;

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str =
    concat!(include_str!("page.js"), include_str!("image.js"), include_str!("catalogue.js"), include_str!("charts.js"));

/// Name of the file.
pub const FILE: &str = "report.html";

/// The page for the data of [`page_data`].
pub fn page(data: &Value) -> String {
    // In JSON `<` stands in texts only, where its escape means the same: no text ends the script.
    let data = data.to_string().replace('<', "\\u003c");
    let mut page = PAGE;
    let mut whole = String::with_capacity(PAGE.len() + STYLE.len() + SCRIPT.len() + data.len());
    for (place, text) in [("/*STYLE*/", STYLE), ("/*DATA*/", &data), ("/*SCRIPT*/", SCRIPT)] {
        let (before, after) = page.split_once(place).unwrap_or((page, ""));
        whole.push_str(before);
        whole.push_str(text);
        page = after;
    }
    whole + page
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn no_text_ends_the_script_or_takes_a_place() {
        let page = page(&json!({ "title": "</script><b>/*SCRIPT*/" }));
        assert_eq!(page.matches("</script>").count(), 2);
        assert!(page.contains(r#"{"title":"\u003c/script>\u003cb>/*SCRIPT*/"}"#));
        assert!(page.ends_with("</html>\n") && page.contains(SCRIPT) && page.contains(STYLE));
    }
}
