//! The frame of a page.

use base64::Engine as _;
use sha2::{Digest as _, Sha256};

use crate::escape;

/// A page, which is one file unless it says that something lies beside it. A policy in it lets the browser run no script but its
/// own, load nothing from elsewhere, and send nothing away, whatever foreign texts the page holds.
#[derive(Clone, Copy, Debug, Default)]
pub struct Page<'a> {
    /// The title, as text.
    pub title: &'a str,
    /// Its styles, one after the other.
    pub styles: &'a [&'a str],
    /// Attributes of the body element, as HTML; most pages have none.
    pub attributes: &'a str,
    /// What is in the body, as HTML.
    pub body: &'a str,
    /// JSON for its script, in the element `data`, where it has some.
    pub data: Option<&'a serde_json::Value>,
    /// The script that runs at its end; none if empty.
    pub script: &'a str,
    /// The address of a file beside the page that has this script, relative to the page. Then the page holds only its address.
    pub script_at: Option<&'a str>,
    /// Whether the script makes images of its own (`blob:`).
    pub makes_images: bool,
    /// Whether images lie in files beside the page.
    pub images_beside: bool,
    /// Whether the script speaks with the server that the page comes from.
    pub connects: bool,
}

impl Page<'_> {
    /// The whole file.
    #[must_use]
    pub fn html(&self) -> String {
        let title = escape(self.title);
        let styles = self.styles.concat();
        let mut images = String::from("data:");
        for (wanted, source) in [(self.makes_images, " blob:"), (self.images_beside, " 'self'")] {
            images.push_str(if wanted { source } else { "" });
        }
        let (mut policy, mut scripts) = (String::new(), String::new());
        if let Some(data) = self.data {
            let data = crate::json(data);
            scripts = format!("<script type=\"application/json\" id=\"data\">{data}</script>");
        }
        if !self.script.is_empty() {
            let hash = |text: &[u8]| base64::engine::general_purpose::STANDARD.encode(Sha256::digest(text));
            let connects = if self.connects { "; connect-src 'self'" } else { "" };
            match self.script_at {
                None => {
                    policy = format!("; script-src 'sha256-{}'{connects}", hash(self.script.as_bytes()));
                    scripts = format!("{scripts}<script>{}</script>", self.script);
                }
                Some(address) => {
                    // Browsers hold a file that lies on a disk against no hash, so a word that only this page has allows the script.
                    // Nobody whose text is in the page can know it, since it is made of all that is in the page.
                    let word =
                        hash(format!("{title}{styles}{}{}{scripts}", self.attributes, self.body).as_bytes());
                    policy = format!("; script-src 'nonce-{word}'{connects}");
                    scripts =
                        format!("{scripts}<script nonce=\"{word}\" src=\"{}\"></script>", escape(address));
                }
            }
        }
        let space = if self.attributes.is_empty() { "" } else { " " };
        format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
             content=\"width=device-width,initial-scale=1\"><meta http-equiv=\"Content-Security-Policy\" \
             content=\"default-src 'none'; base-uri 'none'; form-action 'none'; img-src {images}; style-src 'unsafe-inline'{policy}\"><title>{title}</title>\
             <style>{styles}</style></head><body{space}{}>{}{scripts}</body></html>\n",
            self.attributes, self.body
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_runs_its_own_script_only() {
        let page = Page { title: "<b>", script: "a()", ..Page::default() }.html();
        // SHA-256 of `a()` by sha256sum, in base64.
        assert!(page.contains("script-src 'sha256-qVpDBgj7bpq5hMAcGp3AOc79J3Y1Z4HvySTwKrWDoy4='"), "{page}");
        assert!(page.contains("<title>&lt;b&gt;</title>"), "{page}");
    }

    #[test]
    fn a_script_beside_the_page_is_allowed_by_a_word_that_texts_in_the_page_can_not_know() {
        let page =
            |body: &str| Page { body, script: "a()", script_at: Some("../<a>.js"), ..Page::default() }.html();
        let first = page("<p>one</p>");
        assert!(first.contains("src=\"../&lt;a&gt;.js\"></script>") && !first.contains("a()"), "{first}");
        let word =
            |page: &str| page.split("nonce=\"").nth(1).and_then(|s| s.split('"').next()).map(str::to_owned);
        let own = word(&first).expect("a word");
        assert!(first.contains(&format!("script-src 'nonce-{own}'\"")), "{first}");
        assert_eq!(
            word(&page("<p>one</p>")).as_deref(),
            Some(own.as_str()),
            "the same page has the same bytes"
        );
        // Whoever writes the word of a page into its text has another page.
        let again = page(&format!("<p>one</p><script nonce=\"{own}\">alert(1)</script>"));
        assert!(!again.contains(&format!("'nonce-{own}'")), "{again}");
    }

    #[test]
    fn a_page_without_a_script_runs_none() {
        let page = Page { body: "<p>x</p>", ..Page::default() }.html();
        assert!(page.contains("default-src 'none'") && !page.contains("script"), "{page}");
    }

    #[test]
    fn data_cannot_leave_their_element() {
        let data = serde_json::json!(["</script><script>alert(1)</script>"]);
        let page = Page { data: Some(&data), script: "a()", ..Page::default() }.html();
        assert_eq!(page.matches("<script").count(), 2, "{page}");
    }
}
