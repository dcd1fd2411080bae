"""Programs of the interface specification that the product itself does not use; `docs/specification.md` lists them."""
