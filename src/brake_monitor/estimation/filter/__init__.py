"""x and P of one wagon: where they are kept, within which bounds, and the prediction and correction of them."""
