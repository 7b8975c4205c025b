//! Types that a macro of their file makes: an enum of a list of variants, or a struct of measures.

use syn::parse::{Parse, ParseStream};
use syn::{
    Attribute, Ident, ItemEnum, ItemMacro, ItemStruct, LitStr, Token, Type, Visibility, braced, parse_quote,
};

/// The enum that a `macro_rules!` of this file writes: name of the macro, and the enum without variants.
pub(super) fn enum_of(item: &ItemMacro) -> Option<(String, ItemEnum)> {
    let name = item.ident.as_ref()?.to_string();
    let text = item.mac.tokens.to_string();
    let at = text.find("pub enum ")?;
    let own: String = text[at + "pub enum ".len()..].chars().take_while(|c| c.is_alphanumeric()).collect();
    let own: Ident = syn::parse_str(&own).ok()?;
    // Its attributes stand before it in the body of the macro, behind the modules that it declares.
    let body = text[..at].rsplit_once("=>").map_or(&text[..at], |(_, body)| body);
    let before = body.find('#').map_or("", |at| &body[at..]);
    let attributes = syn::parse::Parser::parse_str(Attribute::parse_outer, before).ok()?;
    let mut made: ItemEnum = parse_quote!(enum #own {});
    made.attrs = attributes;
    Some((name, made))
}

/// The variants of a list: `/// about` and `Variant`, with `= "name"` where files have another one.
pub(super) struct Variants(pub(super) Vec<syn::Variant>);

impl Parse for Variants {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let mut found = Vec::new();
        // A macro that hands itself on begins with a dollar sign.
        input.parse::<Option<Token![$]>>()?;
        while !input.is_empty() {
            let attributes = input.call(Attribute::parse_outer)?;
            let mut name: Ident = input.parse()?;
            let mut variant: syn::Variant = if input.peek(Ident) {
                // A module and a variant without data.
                name = input.parse()?;
                parse_quote!(#name)
            } else if input.peek(Token![:]) {
                // A module and a variant of the data of this name.
                input.parse::<Token![:]>()?;
                name = input.parse()?;
                parse_quote!(#name(#name))
            } else if input.peek(Token![=]) {
                input.parse::<Token![=]>()?;
                let own: LitStr = input.parse()?;
                parse_quote!(#[serde(rename = #own)] #name)
            } else {
                parse_quote!(#name(#name))
            };
            variant.attrs.extend(attributes);
            found.push(variant);
            skip_until(input, |input| input.peek(Token![;]) || input.peek(Token![,]))?;
            // Of `= "name", "title", …;` only the semicolon ends it.
            while input.peek(Token![,]) && !found.is_empty() && !is_next(input) {
                input.parse::<Token![,]>()?;
                skip_until(input, |input| input.peek(Token![;]) || input.peek(Token![,]))?;
            }
            let _ = input.parse::<Token![;]>().map(drop).or_else(|_| input.parse::<Token![,]>().map(drop));
        }
        Ok(Self(found))
    }
}

/// Whether a comma is followed by the next variant, or by nothing.
fn is_next(input: ParseStream<'_>) -> bool {
    let ahead = input.fork();
    ahead.parse::<Token![,]>().is_ok() && (ahead.is_empty() || ahead.peek(Token![#]))
}

fn skip_until(input: ParseStream<'_>, ends: impl Fn(ParseStream<'_>) -> bool) -> syn::Result<()> {
    while !input.is_empty() && !ends(input) {
        input.step(|cursor| {
            let (_, rest) = cursor.token_tree().ok_or_else(|| cursor.error("there is nothing left"))?;
            Ok(((), rest))
        })?;
    }
    Ok(())
}

/// A struct of measures: `"name": pub struct Name { /// about \n pub field: Type => …, }`.
pub(super) struct Measures(pub(super) ItemStruct);

impl Parse for Measures {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let attributes = input.call(Attribute::parse_outer)?;
        input.parse::<LitStr>()?;
        input.parse::<Token![:]>()?;
        input.parse::<Visibility>()?;
        input.parse::<Token![struct]>()?;
        let name: Ident = input.parse()?;
        let body;
        braced!(body in input);
        let mut fields: Vec<syn::Field> = Vec::new();
        while !body.is_empty() {
            let attributes = body.call(Attribute::parse_outer)?;
            body.parse::<Visibility>()?;
            let field: Ident = body.parse()?;
            body.parse::<Token![:]>()?;
            let ty: Type = body.parse()?;
            let mut one: syn::Field = parse_quote!(#field: #ty);
            one.attrs = attributes;
            fields.push(one);
            skip_until(&body, |body| body.peek(Token![,]))?;
            body.parse::<Option<Token![,]>>()?;
        }
        let mut made: ItemStruct = parse_quote!(struct #name { #(#fields),* });
        made.attrs = attributes;
        Ok(Self(made))
    }
}
