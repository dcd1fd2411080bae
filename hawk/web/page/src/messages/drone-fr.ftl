### Les phrases du programme du drone en français, dans la syntaxe de Fluent. drone-en.ftl (écrit par
### packaging/sentences.py) les donne en anglais : mêmes codes, mêmes valeurs.
###
### Les mêmes termes que dans fr.ftl.

the-autopilot-reports-a-fault-words = L'autopilote signale une panne : { $words }
the-autopilot-words = L'autopilote : { $words }
the-autopilot-warns-words = L'autopilote avertit : { $words }
east = est
text = { $text }.
value-m = { $value }{ "\u00A0" }m
north = nord
north-east = nord-est
north-west = nord-ouest
value-s = { $value }{ "\u00A0" }s
south = sud
south-east = sud-est
south-west = sud-ouest
first-second = { $first } { $second }
west = ouest
