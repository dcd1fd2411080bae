### Sentences of the drone's program in English, in Fluent's syntax. Written by packaging/sentences.py from the program:
### change its sentence and run this again. drone-fr.ftl and its like translate them.

east = east
first-second = { $first } { $second }
north = north
north-east = north-east
north-west = north-west
south = south
south-east = south-east
south-west = south-west
text = { $text }.
the-autopilot-reports-a-fault-words = The autopilot reports a fault: { $words }
the-autopilot-warns-words = The autopilot warns: { $words }
the-autopilot-words = The autopilot: { $words }
value-m = { $value } m
value-s = { $value } s
west = west
