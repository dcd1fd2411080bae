# A report of a lot's use, on paper. What stands behind $ is a number, a date or a name in the report's own language.

kind-of-document = Rapport de relevés de parking
author = Parking Lot Hawk, { $program }
times = Les heures sont celles de { $zone }.
made = Établi le { $at }.
period = { $first } au { $last }
page = Page
page-of = sur

asked-heading = Question posée :
asked = combien de places { $part } sont occupées, { $days }, { $hours }.
part-lot = du parking
part-rows = { $count ->
    [one] de la rangée { $names }
   *[other] des rangées { $names }
}
part-zones = { $count ->
    [one] de la zone { $names }
   *[other] des zones { $names }
}
part-kinds = du type { $names }
any-day = tous les jours
days = { $runs }
days-run = { $first } à { $last }
any-hour = à toute heure
hours = { $runs }
hours-run = de { $first } à { $last }
no-answer = Aucun relevé de cette période ne compte : personne n’a volé, ou chaque relevé a été écarté.
surveyed = { $surveys ->
    [one] Un relevé, sur un jour, a observé
   *[other] { $surveys } relevés, sur { $days ->
        [one] un jour
       *[other] { $days } jours
    }, ont observé
} { $stalls ->
    [one] son unique place
   *[other] ses { $stalls } places
}.
answer = En moyenne, { $share } étaient occupées
answer-range = ({ $range }) : { $amount } des { $stalls } places ({ $amounts }).
simulated = { $count ->
    [one] Un relevé a été volé par un simulateur : ses voitures sont dessinées, non réelles.
   *[other] { $count } relevés ont été volés par un simulateur : leurs voitures sont dessinées, non réelles.
}

range = { $low } à { $high }
free = libre
taken = occupée
unclear = incertaine
free-stalls = libres
free-estimated = libres, estimées
taken-stalls = occupées
unclear-stalls = incertaines
north = N
metres = { $metres } m
picture = Le parking vu d’en haut, avec ses places
newest = Dernier relevé, { $at } : { $free } { $free ->
    [one] libre
   *[other] libres
}, { $taken } { $taken ->
    [one] occupée
   *[other] occupées
}, { $unclear } { $unclear ->
    [one] incertaine
   *[other] incertaines
} ; { $share } occupées ({ $range }).
labels-painted = Lettres et numéros sont ceux peints au sol.
labels-guessed = Lettres et numéros sont notre estimation.
labels-both = { $named } étiquettes sur { $stalls } sont celles peintes au sol, les autres notre estimation.
zones-dotted = En pointillé : les zones.
picture-broken = L’image de ce relevé est endommagée ; elle est omise.
nothing-to-draw = Il n’y a ni image ni place à dessiner.
by-link = Un lien ne montre pas le sol.
not-kept = L’image de ce relevé n’est plus conservée.

in-short = En bref
mean = occupées, moyenne de { $hours ->
    [one] une heure relevée
   *[other] { $hours } heures relevées
}
fullest = le plus plein : { $at }
emptiest = le plus vide : { $at }
only = seul relevé : { $at }
fullest-row = rangée la plus pleine, { $share } occupées
fullest-row-name = Rangée { $row }
stalls-taken = places occupées en moyenne, sur { $stalls }

curve = Occupées, %, par relevé
curve-words = Part des places occupées à chaque relevé
rows = Rangées
rows-asked = Rangées, aux heures demandées
row = Rangée
stalls = places
always = toujours
always-words = Toujours : places que chaque relevé de la période a trouvées occupées.
lot = Parking
asked-part = Demandé
name = Nom
range-head = 9 sur 10

ranges-hold = Les fourchettes contiennent la vraie valeur 9 fois sur 10.
hatched = Hachuré : personne n’a volé.
rivals = { $count ->
    [one] Un autre relevé a pu être aussi plein que le plus plein.
   *[other] { $count } autres relevés ont pu être aussi pleins que le plus plein.
}
between = Les heures entre les relevés n’ont pas été vues.
left-out-of = { $count ->
    [one] Un relevé est écarté ; la liste des relevés dit pourquoi.
   *[other] { $count } relevés sont écartés ; la liste des relevés dit pourquoi.
}
nobody-identified = Aucune voiture ni personne n’a été identifiée.
unreadable = { $count ->
    [one] Un relevé ou une version du plan est endommagé sur le disque, et ne figure dans aucune liste.
   *[other] { $count } relevés ou versions du plan sont endommagés sur le disque, et ne figurent dans aucune liste.
}

heat-map = Jour de la semaine et heure
heat-map-words = Part moyenne des places occupées à chaque heure de la semaine, avec sa fourchette. Vide : personne n’a volé. Encadré : demandé.
heat-map-all = Part moyenne des places occupées à chaque heure de la semaine, avec sa fourchette. Vide : personne n’a volé.
hour = Heure
zones = Zones
zone = Zone
no-zone = sans zone
other-row = autre
kinds = Types de places
stall-kind = Type
kind = { $kind ->
    [disabled] personnes handicapées
    [charging] véhicules électriques
    [parent] parents avec enfants
    [delivery] livraisons
    [private] réservées
    [motorcycle] motos
    [staff] personnel
    [bus] autobus
    [hgv] poids lourds
    [taxi] taxis
   *[normal] ordinaires
}

surveys = Relevés
survey = Relevé
by-pictures = par des images d’autrui
by-simulator = simulé
surveys-cut = Les { $shown } derniers relevés sur { $count }. Le classeur les liste tous.
rows-cut = Les { $shown } premières sur { $count }. Le classeur les liste toutes.
left-out = Écartés
why = Pourquoi
why-deleted = supprimé par une personne
why-unregistered = sa position sur le parking n’est pas certaine
why-no_time = son heure n’est pas sûre
why-no_looks = il n’a observé aucune place du parking
why-unseen = il n’a vu aucune des places demandées
layouts = Changements du plan
since = Depuis
layout-first = trouvé par le premier relevé
layout-corrected = corrigé à la main
layout-taken = repris d’un relevé

method = Méthode et limites
method-look = Un relevé observe chaque place d’en haut. Un programme décide si elle est libre ou occupée, avec une probabilité ; s’il ne le peut pas, la place est incertaine et ne compte ni comme libre ni comme occupée.
method-range = Une fourchette contient la vraie valeur 9 fois sur 10. Elle tient compte des états erronés, des places qui n’ont pas été vues et de ce qui a changé dans l’heure du relevé.
method-mean = Une moyenne porte sur les heures avec un relevé, qui comptent toutes autant. Une heure où personne n’a volé n’entre dans aucun chiffre ; elle n’est pas zéro.
method-between = Un relevé montre un instant. Rien n’est connu du temps entre deux relevés : une place libre dans les deux a pu être occupée entre-temps.
method-always = Une place compte comme toujours occupée si deux relevés ou plus l’ont vue, et que chacun l’a trouvée occupée.
method-labels = Les étiquettes sont celles peintes au sol si une personne les a confirmées, sinon notre estimation. Ce sont celles du plan actuel, même pour un relevé ancien.
method-pictures = { $count ->
    [one] Un relevé a été fait d’images prises par d’autres : ses positions et son heure sont les leurs.
   *[other] { $count } relevés ont été faits d’images prises par d’autres : leurs positions et leurs heures sont les leurs.
}
method-private = Aucune plaque n’est lue ; aucune voiture ni personne n’est identifiée ou suivie.

summary = Résumé
what = Quoi
value = Valeur
low = Bas
high = Haut
count-surveys = Relevés
unit = Unité
weekday = Jour
is-asked = Demandé
days-head = Jours
label = Étiquette
id = Identifiant
share-taken = Occupées
surveys-seen = Relevés avec un état
began = Début
ended = Fin
clock = Fuseau horaire
first-day = Premier jour
last-day = Dernier jour
made-at = Établi
question = Question
unit-share = part des places
unit-stalls = places
state = { $state ->
    [free] libre
    [taken] occupée
    [unseen] incertaine
   *[none] {""}
}
mean-share = Occupées, moyenne des heures relevées
mean-stalls = Places occupées, moyenne des heures relevées
hours-surveyed = Heures relevées
fullest-survey = Relevé le plus plein
emptiest-survey = Relevé le plus vide
yes = oui
states-cut = États des { $shown } derniers relevés sur { $count }.

# -- sections: vehicles that were counted

sections = Sections
sections-words = Véhicules comptés par le relevé du { $at }. Les sections comptent des véhicules, par rapport à leurs places ; tous les autres chiffres comptent des places.
section = Section
vehicles = Véhicules
section-places = Capacité
section-occupancy = Des places
section-room = Place pour
section-hidden = Caché, pas vu
section-given = Places selon une personne
section-note = Note
sections-hours = Sections, jour par heure : { $names }
sections-hours-places = Nombre moyen de véhicules à chaque heure de la semaine, par rapport à { $places } places, avec sa fourchette. Vide : personne n’a volé.
sections-hours-alone = Nombre moyen de véhicules à chaque heure de la semaine, avec sa fourchette. Vide : personne n’a volé. Le nombre de places n’est pas indiqué.

# -- plusieurs parkings : la première page

lots = { $count ->
    [one] Un parking
   *[other] { $count } parkings
}
lots-head = Parkings
part-lots = de chaque parking
times-of-each = Les heures sont celles de chaque parking.
lots-newest = Le tableau donne le relevé le plus récent de chaque parking ; ses propres pages donnent la réponse.
newest-survey = Dernier relevé
no-survey = aucun relevé qui compte
drone = Drone
due = Relevé dû
due-since = depuis { $when }
total = Total
lots-together = On n’a pas mesuré comment les erreurs des parkings vont ensemble : la fourchette du total additionne les bornes de toutes, comme si tous les parkings se trompaient de la même façon.
lots-apart = Si chaque parking se trompait pour lui-même, { $range } places seraient libres.
lots-apart-vehicles = Si chaque parking se trompait pour lui-même, il y aurait { $range } véhicules dans les sections.
lots-unseen = Libres, estimées : de toutes les places. Celles qu’un relevé n’a pas vues sont prises pour aussi occupées que les autres.
lots-moments = Le total n’est d’aucun moment précis : les relevés vont du { $first } au { $last }.
lots-uncounted = { $count ->
    [one] Un parking n’a aucun relevé qui compte et n’est dans aucun total.
   *[other] { $count } parkings n’ont aucun relevé qui compte et ne sont dans aucun total.
}
sections-unseen = { $count ->
    [one] une section non vue
   *[other] { $count } sections non vues
}
total-alike = Total, comme si tous les parkings se trompaient de la même façon
total-apart = Total, comme si chaque parking se trompait pour lui-même
number = Numéro
age-days = Âge, jours
