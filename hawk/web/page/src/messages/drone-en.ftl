### Sentences of the drone's program in English, in Fluent's syntax. Written by packaging/sentences.py from the program:
### change its sentence and run this again. drone-fr.ftl and its like translate them.

autopilot-fault = The autopilot reports a fault: { $words }
autopilot-says = The autopilot: { $words }
autopilot-warns = The autopilot warns: { $words }
east = east
full-stop = { $text }.
metres = { $value } m
north = north
north-east = north-east
north-west = north-west
seconds = { $value } s
south = south
south-east = south-east
south-west = south-west
two-sentences = { $first } { $second }
west = west
